// SPDX-License-Identifier: GPL-3.0-or-later
// Sliders for a box that crops the surface, and its outline in the picture. The box stands upright.
import {add, dot, lookingAlong, quaternionOf, rotationOf, row, times, turned} from '../camera.js';
import {element, part, pathElement} from '../elements.js';
import {projected} from '../over/surface_points.js';
/** @import {Viewer} from '../viewer.js' */
/** @import {CropBox, Rotation, SaidKey, Vector} from '../types.d.ts' */

/** @type {SaidKey[]} */
const SIDES = ['left', 'right', 'bottom', 'top', 'back', 'front'];  // least and most along each axis
const STEPS = 200;           // of a slider
const OUTLIERS = 0.002;      // share of vertices beyond a box's range at each side
const AROUND = 0.15;         // share of the range, around it
const SAMPLES = 20000;       // vertices that the range is found of

/** @typedef {{rotation: Rotation, ranges: [number, number][]}} CropFrame */

// The axes of a box that stands upright, turned about what is upwards by degrees: right, up, and towards the viewer.
/** @param {Vector} up @param {number} degrees @returns {Rotation} */
function uprightAxes(up, degrees) {
  const side = Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
  const level = lookingAlong(add(side, up, -dot(side, up)), up);
  const rotation = turned(level, up, degrees * Math.PI / 180);
  return [...row(rotation, 0), ...times(row(rotation, 1), -1), ...times(row(rotation, 2), -1)];
}

// The range of most vertices along each axis.
/** @param {Float32Array} positions @param {Rotation} rotation @returns {[number, number][]} */
function rangesOf(positions, rotation) {
  const step = 3 * Math.max(1, Math.floor(positions.length / 3 / SAMPLES));
  return [0, 1, 2].map((axis) => {
    const [x, y, z] = row(rotation, axis);
    /** @type {number[]} */
    const along = [];
    for (let i = 0; i < positions.length; i += step) {
      along.push(x * positions[i] + y * positions[i + 1] + z * positions[i + 2]);
    }
    along.sort((a, b) => a - b);
    const at = (/** @type {number} */ share) => along[Math.round(share * (along.length - 1))] ?? 0;
    const margin = AROUND * (at(1 - OUTLIERS) - at(OUTLIERS));
    return [at(OUTLIERS) - margin, at(1 - OUTLIERS) + margin];
  });
}

export class CropControls {
  // `changed` is told the box; null: there is none.
  /** @param {Viewer} viewer @param {(crop: CropBox | null) => void} changed */
  constructor(viewer, changed) {
    this.viewer = viewer;
    this.changed = changed;
    this.on = element('crop-on', HTMLInputElement);
    this.turn = element('crop-turn', HTMLInputElement);
    /** @type {CropBox | null} */
    this.crop = null;
    /** @type {CropFrame | null} */
    this.frame = null;
    this.frameKey = '';  // what the frame was made for
    this.sliders = SIDES.map((side) => {
      const label = document.createElement('label');
      const slider = document.createElement('input');
      slider.type = 'range';
      slider.max = String(STEPS);
      label.append(viewer.texts.say(side), slider);
      slider.addEventListener('input', () => this.take());
      return slider;
    });
    part('crop-sliders').prepend(...this.sliders.map((slider) => /** @type {HTMLElement} */ (slider.parentElement)));
    this.on.addEventListener('change', () => this.toggle());
    this.turn.addEventListener('input', () => this.take());
    this.outline = pathElement('crop-outline');
  }

  // Shows a box of the owner's file.
  /** @param {CropBox | null} crop */
  set(crop) {
    this.crop = crop;
    this.on.checked = crop !== null;
    part('crop-sliders').hidden = crop === null;
    this.frame = null;
    if (crop) this.fill(crop);
  }

  // Sets the sliders to a box, whose axes are upright ones.
  /** @param {CropBox} crop */
  fill({center, size, turned: quaternion}) {
    const axes = rotationOf(quaternion);
    const zero = uprightAxes(this.viewer.navigation.up, 0);
    const sine = dot(row(axes, 0), row(zero, 2));
    const degrees = Math.round(Math.atan2(-sine, dot(row(axes, 0), row(zero, 0))) * 180 / Math.PI);
    this.turn.value = String(degrees);
    const {ranges} = this.frameAt(Number(this.turn.value));
    ranges.forEach(([least, most], axis) => {
      const middle = dot(center, row(axes, axis));
      for (const end of [0, 1]) {
        const side = middle + (end - 0.5) * size[axis];
        this.sliders[2 * axis + end].value = String(Math.round((side - least) / (most - least) * STEPS));
      }
    });
  }

  toggle() {
    this.crop = null;
    this.frame = null;
    part('crop-sliders').hidden = !this.on.checked;
    if (!this.on.checked) return this.changed(null);
    this.turn.value = '0';
    this.sliders.forEach((slider, i) => {
      slider.value = String(i % 2 * STEPS);
    });
    this.take();
  }

  // The frame of the sliders.
  /** @param {number} degrees */
  frameAt(degrees) {
    const rotation = uprightAxes(this.viewer.navigation.up, degrees);
    return {rotation, ranges: rangesOf(this.viewer.renderer.surface.positions(), rotation)};
  }

  // Makes the box that the sliders say.
  take() {
    const degrees = Number(this.turn.value);
    const key = `${degrees} ${this.viewer.navigation.up}`;
    if (!this.frame || this.frameKey !== key) this.frame = this.frameAt(degrees);
    this.frameKey = key;
    const {rotation, ranges} = this.frame;
    const sides = ranges.map(([least, most], axis) => [0, 1].map((end) =>
        least + (most - least) * Number(this.sliders[2 * axis + end].value) / STEPS));
    const middles = sides.map(([low, high]) => (low + high) / 2);
    this.crop = {
      center: middles.reduce((sum, middle, axis) => add(sum, row(rotation, axis), middle), [0, 0, 0]),
      size: sides.map(([low, high]) => Math.max(0, high - low)), turned: quaternionOf(rotation),
    };
    this.changed(this.crop);
  }

  // Draws the outline of the box over the picture. `isShown`: the owner is editing.
  /** @param {boolean} isShown */
  drawOutline(isShown) {
    const {crop, viewer} = this;
    const {drawn, canvas} = viewer;
    this.outline.toggleAttribute('hidden', !isShown || !crop || !drawn);
    if (!isShown || !crop || !drawn) return;
    const axes = rotationOf(crop.turned);
    const corners = Array.from({length: 8}, (_, corner) => [0, 1, 2].reduce(
        (sum, axis) => add(sum, row(axes, axis), (corner >> axis & 1 ? 0.5 : -0.5) * crop.size[axis]), crop.center));
    const places = corners.map((corner) => projected(drawn.camera, corner));
    const across = canvas.clientWidth / drawn.camera.width;
    const down = canvas.clientHeight / drawn.camera.height;
    let path = '';
    for (let corner = 0; corner < 8; ++corner) {
      for (const step of [1, 2, 4]) {
        const [from, to] = [places[corner], places[corner | step]];
        if (corner & step || !from || !to) continue;
        path += `M${from.x * across} ${from.y * down}L${to.x * across} ${to.y * down}`;
      }
    }
    this.outline.setAttribute('d', path);
  }
}
