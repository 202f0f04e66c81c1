// SPDX-License-Identifier: GPL-3.0-or-later
// Compares a stored photograph with the model's picture from the same camera: a divider stands between both.
import {dot, length, poseOf, row, subtract} from '../camera.js';
import {button, element, part} from '../elements.js';
import {FetchFailure} from '../reading/fetching.js';
import {loadPhotograph} from '../reading/model.js';
/** @import {Viewer} from '../viewer.js' */
/** @import {Pose, SaidKey, View} from '../types.d.ts' */

const AT_PHOTOGRAPH = 1e-3;     // in depths and radians
const DIVIDER_STEP = 2;      // per cent of the picture's width
const DIVIDER_LONG_STEP = 10;

/** @type {Record<string, number>} */
const DIVIDER_KEYS = {
  ArrowLeft: -DIVIDER_STEP, ArrowDown: -DIVIDER_STEP, ArrowRight: DIVIDER_STEP, ArrowUp: DIVIDER_STEP,
  PageDown: -DIVIDER_LONG_STEP, PageUp: DIVIDER_LONG_STEP, Home: -100, End: 100,
};

export class Comparison {
  /** @param {Viewer} viewer */
  constructor(viewer) {
    this.viewer = viewer;
    this.box = part('comparison');
    this.divider = part('divider');
    this.image = element('photograph', HTMLCanvasElement);
    /** @type {Pose | null} */
    this.seen = null;  // the pose for which `slot` was found
    this.slot = -1;    // number of the photograph at whose camera the visitor stands; -1: none
    this.on = false;
    this.photograph = '';  // file that the image shows, or will show
    this.at = 50;      // place of the divider, per cent from the left
    button('compare').addEventListener('click', () => this.toggle());
    this.divider.addEventListener('keydown', (event) => this.keyPressed(event));
    this.divider.addEventListener('pointerdown', (event) => {
      event.preventDefault();
      this.divider.setPointerCapture(event.pointerId);
      this.divider.focus();
    });
    this.divider.addEventListener('pointermove', (event) => {
      if (this.divider.hasPointerCapture(event.pointerId)) this.dragTo(event.clientX);
    });
    this.moveTo(50);
  }

  // Returns the number of the photograph that has the camera's position and direction; -1: none has.
  photographHere() {
    const {navigation, scene} = this.viewer;
    if (navigation.jump) return -1;
    const {pose, typicalDepth} = navigation;
    return scene.views.findIndex((view) => {
      if (!view) return false;
      const there = poseOf(view);
      if (length(subtract(there.position, pose.position)) > AT_PHOTOGRAPH * typicalDepth) return false;
      return [0, 2].every((axis) => dot(row(there.rotation, axis), row(pose.rotation, axis)) > 1 - AT_PHOTOGRAPH ** 2);
    });
  }

  // Called before each frame: the photograph follows the window's size, and leaving its place ends the comparison.
  follow() {
    const {navigation, canvas} = this.viewer;
    if (this.seen !== navigation.pose) {
      this.seen = navigation.pose;
      const here = this.photographHere();
      if (here !== this.slot) this.end();
      this.slot = here;
      button('compare').hidden = here < 0;
    }
    if (this.on) this.place(canvas.clientWidth, canvas.clientHeight);
  }

  toggle() {
    if (this.on) return this.end();
    const view = this.viewer.scene.views[this.slot];
    if (!view) return;
    this.on = true;
    if (this.photograph !== view.photograph) this.viewer.quietly(this.load(view, this.slot));
    this.moveTo(50);
    this.show();
    this.divider.focus();
  }

  end() {
    if (!this.on) return;
    this.on = false;
    if (this.box.contains(document.activeElement)) this.viewer.canvas.focus();
    this.show();
  }

  show() {
    this.box.hidden = !this.on;
    button('compare').setAttribute('aria-pressed', String(this.on));
  }

  /** @param {SaidKey} key */
  tell(key) {
    part('photograph-side').textContent = this.viewer.texts.say(key);
  }

  // Shows a photograph once it is there. A failed one is asked for again with the next comparison.
  /** @param {View} view @param {number} slot */
  async load(view, slot) {
    this.photograph = view.photograph;
    this.image.width = this.image.height = 0;
    this.tell('photographLoads');
    try {
      const photograph = await loadPhotograph(this.viewer.files, view);
      if (this.photograph === view.photograph) this.draw(photograph, view, slot);
      photograph.close();
    } catch (error) {
      if (!(error instanceof FetchFailure)) throw error;
      if (this.photograph !== view.photograph) return;
      this.photograph = '';
      this.tell('photographFails');
    }
  }

  // Draws a photograph without the tiles that the model does not keep.
  /** @param {ImageBitmap} photograph @param {View} view @param {number} slot */
  draw(photograph, view, slot) {
    const {image, viewer} = this;
    const {resident, scene} = viewer;
    [image.width, image.height] = [photograph.width, photograph.height];
    const context = image.getContext('2d');
    if (!context) return;
    context.drawImage(photograph, 0, 0);
    const tiles = viewer.renderer.photographs?.layout.views[slot];
    const side = scene.tile * photograph.width / view.width;
    let missing = 0;
    for (let tile = 0; tiles && tile < tiles.count; ++tile) {
      if (resident[tiles.first + tile]) continue;
      context.clearRect(tile % tiles.columns * side, Math.floor(tile / tiles.columns) * side, side, side);
      ++missing;
    }
    this.tell(missing > 0 ? 'photographInPart' : 'photograph');
  }

  // Lays the photograph over the picture of its camera, whose principal point is the window's middle.
  /** @param {number} width @param {number} height */
  place(width, height) {
    const view = this.viewer.scene.views[this.slot];
    if (!view) return this.end();
    const focal = height / 2 / Math.tan(this.viewer.navigation.fov * Math.PI / 360);
    const [across, down] = [focal / view.fx, focal / view.fy];
    const {style} = this.image;
    style.width = `${across * view.width}px`;
    style.height = `${down * view.height}px`;
    style.left = `${width / 2 - across * view.cx}px`;
    style.top = `${height / 2 - down * view.cy}px`;
  }

  /** @param {KeyboardEvent} event */
  keyPressed(event) {
    if (event.key === 'Escape') this.end();
    const step = DIVIDER_KEYS[event.key];
    if (step === undefined && event.key !== 'Escape') return;
    event.preventDefault();
    if (step !== undefined) this.moveTo(this.at + step);
  }

  /** @param {number} clientX */
  dragTo(clientX) {
    const {left, width} = this.box.getBoundingClientRect();
    this.moveTo(100 * (clientX - left) / width);
  }

  /** @param {number} percent */
  moveTo(percent) {
    this.at = Math.max(0, Math.min(100, percent));
    this.box.style.setProperty('--at', `${this.at}%`);
    this.divider.setAttribute('aria-valuenow', String(Math.round(this.at)));
    const words = this.viewer.texts.say('dividerAt', {percent: Math.round(this.at)});
    this.divider.setAttribute('aria-valuetext', words);
  }
}
