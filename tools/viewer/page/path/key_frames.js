// SPDX-License-Identifier: GPL-3.0-or-later
// The panel in which the visitor lays a camera's path of key frames, plays it, and saves it for `lumatlas render`.
import {quaternionOf, rotationOf} from '../camera.js';
import {actionButton, button, part, pathElement} from '../elements.js';
import {projected} from '../over/surface_points.js';
import {save} from '../saving.js';
import {CameraPath, printPath} from './camera_path.js';
/** @import {Viewer} from '../viewer.js' */
/** @import {KeyFrame, Vantage} from '../types.d.ts' */

const FIRST_SECONDS = 2;     // from a key frame to the next
const LEAST_SECONDS = 0.1;
const MOST_SECONDS = 3600;
const POINTS_A_FRAME = 16;   // of the shown line, between two key frames
const PATH_FILE_NAME = 'path.json';

// Degrees across a picture, of degrees from top to bottom; with `aspect` turned over, the other way.
/** @param {number} degrees @param {number} aspect */
const otherFov = (degrees, aspect) => 2 * Math.atan(Math.tan(degrees * Math.PI / 360) * aspect) * 180 / Math.PI;

export class KeyFrames {
  /** @param {Viewer} viewer */
  constructor(viewer) {
    this.viewer = viewer;
    /** @type {{vantage: Vantage, seconds: number}[]} */
    this.frames = [];  // `seconds`: to the next
    this.isOpen = false;
    /** @type {number | null} */
    this.startedAt = null;  // null: it is not played
    this.line = pathElement('path-line');
    button('key-add').addEventListener('click', () => this.add());
    button('key-play').addEventListener('click', () => this.play(this.startedAt === null));
    button('key-save').addEventListener('click', () => this.download());
    for (const name of ['pointerdown', 'keydown', 'wheel']) {
      viewer.canvas.addEventListener(name, () => this.play(false), {passive: true});
    }
  }

  /** @param {boolean} open */
  turn(open) {
    this.isOpen = open;
    if (!open) this.play(false);
    this.tell();
    this.drawLine();
  }

  // The window's height over its width.
  aspect() {
    const {clientWidth, clientHeight} = this.viewer.canvas;
    return clientHeight / clientWidth;
  }

  add() {
    const {pose, fov} = this.viewer.navigation;
    const turned = quaternionOf(pose.rotation);
    const vantage = {position: [...pose.position], turned, fov: otherFov(fov, 1 / this.aspect())};
    this.frames.push({vantage, seconds: FIRST_SECONDS});
    this.changed();
  }

  // Returns the key frames with their times.
  /** @returns {KeyFrame[]} */
  keys() {
    let time = 0;
    return this.frames.map(({vantage, seconds}) => {
      const key = {time, vantage};
      time += seconds;
      return key;
    });
  }

  changed() {
    this.play(false);
    part('key-frames').replaceChildren(...this.frames.map((_, i) => this.entry(i)));
    button('key-play').disabled = this.frames.length < 2;
    button('key-save').disabled = this.frames.length === 0;
    this.tell();
    this.drawLine();
  }

  tell() {
    const keys = this.keys();
    const seconds = keys.length > 1 ? keys[keys.length - 1].time : 0;
    const values = {count: keys.length, seconds: Number(seconds.toFixed(1))};
    part('key-status').textContent = this.viewer.texts.say('keys', values);
  }

  /** @param {number} i */
  entry(i) {
    const entry = document.createElement('li');
    entry.className = 'row';
    const seconds = document.createElement('input');
    Object.assign(seconds, {type: 'number', min: LEAST_SECONDS, max: MOST_SECONDS, step: 0.5});
    seconds.value = String(this.frames[i].seconds);
    const {texts} = this.viewer;
    const number = i + 1;
    seconds.setAttribute('aria-label', texts.say('secondsToNext', {number}));
    seconds.addEventListener('change', () => {
      const wanted = Number(seconds.value);
      const isGood = wanted >= LEAST_SECONDS && wanted <= MOST_SECONDS;
      if (isGood) this.frames[i].seconds = wanted;
      seconds.value = String(this.frames[i].seconds);
      this.changed();
      if (isGood) return;
      part('key-status').textContent = texts.say('badSeconds', {least: LEAST_SECONDS, most: MOST_SECONDS});
    });
    const isLast = i === this.frames.length - 1;
    entry.append(
        actionButton(String(number), () => this.goTo(i), texts.say('goToKey', {number})),
        ...isLast ? [] : [seconds, texts.say('seconds')],
        actionButton('↑', () => this.move(i), texts.say('moveKeyUp', {number})),
        actionButton('✕', () => this.delete(i), texts.say('deleteKey', {number})));
    return entry;
  }

  /** @param {number} i */
  goTo(i) {
    const {position, turned, fov} = this.frames[i].vantage;
    this.play(false);
    this.viewer.navigation.goTo(
        {position: [...position], rotation: rotationOf(turned)}, otherFov(fov, this.aspect()), performance.now());
  }

  // Changes places with the one before; the first becomes the last.
  /** @param {number} i */
  move(i) {
    const [moved] = this.frames.splice(i, 1);
    this.frames.splice(i > 0 ? i - 1 : this.frames.length, 0, moved);
    this.changed();
  }

  /** @param {number} i */
  delete(i) {
    this.frames.splice(i, 1);
    this.changed();
  }

  /** @param {boolean} plays */
  play(plays) {
    if (plays === (this.startedAt !== null)) return;
    this.startedAt = plays && this.frames.length > 1 ? performance.now() : null;
    button('key-play').textContent = this.viewer.texts.say(this.startedAt === null ? 'play' : 'stop');
    button('key-play').setAttribute('aria-pressed', String(this.startedAt !== null));
    this.drawLine();
  }

  // Called before each frame: goes on along the path that is played.
  follow() {
    if (this.startedAt === null) return;
    const path = new CameraPath(this.keys());
    const time = (performance.now() - this.startedAt) / 1000;
    const {position, turned, fov} = path.at(time);
    this.viewer.navigation.set({position, rotation: rotationOf(turned)}, otherFov(fov, this.aspect()));
    this.viewer.moved();
    if (time >= path.end()) this.play(false);
  }

  // Draws the path over the picture, unless it is played.
  drawLine() {
    const {drawn, canvas} = this.viewer;
    const isShown = this.isOpen && this.startedAt === null && this.frames.length > 1 && drawn;
    this.line.toggleAttribute('hidden', !isShown);
    if (!isShown) return;
    const path = new CameraPath(this.keys());
    const count = POINTS_A_FRAME * (this.frames.length - 1);
    const across = canvas.clientWidth / drawn.camera.width;
    const down = canvas.clientHeight / drawn.camera.height;
    let line = '';
    let pen = 'M';
    for (let i = 0; i <= count; ++i) {
      const place = projected(drawn.camera, path.at(path.end() * i / count).position);
      if (place) line += `${pen}${place.x * across} ${place.y * down}`;
      pen = place ? 'L' : 'M';
    }
    this.line.setAttribute('d', line);
  }

  download() {
    const text = printPath(this.keys(), this.viewer.offset);
    save(new Blob([text], {type: 'application/json'}), PATH_FILE_NAME);
    part('key-status').textContent = this.viewer.texts.say('saved', {file: PATH_FILE_NAME});
  }
}
