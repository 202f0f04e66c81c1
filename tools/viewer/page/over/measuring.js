// SPDX-License-Identifier: GPL-3.0-or-later
// Measures the distance between two points of the surface that the visitor clicks.
import {add, length, subtract, times} from '../camera.js';
import {button, part, pathElement} from '../elements.js';
import {SurfaceTaps} from './surface_taps.js';
/** @import {Mark, Marks} from './marks.js' */
/** @import {Viewer} from '../viewer.js' */
/** @import {LengthUnit, SurfacePoint} from '../types.d.ts' */

const MOST_DIGITS = 9;    // after the point
const PLAIN_DIGITS = 4;   // that count, of a length without a deviation

// Returns a length as text, with as many digits as its deviation has meaning; null: the deviation is not known.
/** @param {number} value @param {number | null} deviation @param {string} unit */
export function lengthText(value, deviation, unit) {
  const isRough = deviation !== null && deviation > 0;
  const last = isRough ? Math.floor(Math.log10(deviation)) - 1 :
    Math.floor(Math.log10(Math.max(value, 1e-300))) - PLAIN_DIGITS + 1;
  const digits = Math.max(0, Math.min(MOST_DIGITS, -last));
  const numbers = [value, ...isRough ? [deviation] : []].map((number) => number.toFixed(digits));
  return `${numbers.join(' ± ')} ${unit}`;
}

// Returns the distance of two points in scene units, and its standard deviation where both points have one. Each
// deviation counts in full, whatever its direction.
/** @param {SurfacePoint} a @param {SurfacePoint} b */
export function distanceOf(a, b) {
  const isKnown = a.deviation !== null && b.deviation !== null;
  return {
    value: length(subtract(a.point, b.point)),
    deviation: isKnown ? Math.hypot(a.deviation ?? 0, b.deviation ?? 0) : null,
  };
}

export class Measuring {
  /** @param {Viewer} viewer @param {Marks} marks @param {LengthUnit} unit */
  constructor(viewer, marks, unit) {
    this.viewer = viewer;
    this.marks = marks;
    this.unit = unit;
    this.taps = new SurfaceTaps(viewer, (point) => this.take(point));
    /** @type {SurfacePoint[]} */
    this.points = [];
    /** @type {Mark[]} */
    this.shown = [];
    /** @type {Mark | null} */
    this.label = null;
    this.line = pathElement('measured-line');
    button('measure-anew').addEventListener('click', () => this.clear());
  }

  /** @param {boolean} on */
  turn(on) {
    this.taps.turn(on);
    this.clear();
    if (on) this.viewer.canvas.focus({preventScroll: true});
  }

  /** @param {LengthUnit} unit */
  setUnit(unit) {
    this.unit = unit;
    if (this.points.length === 2) this.tell();
  }

  // A third point begins anew.
  /** @param {SurfacePoint | null} point */
  take(point) {
    if (!point) {
      part('measured').textContent = this.viewer.texts.say('noSurface');
      return;
    }
    if (this.points.length === 2) this.clear();
    this.points.push(point);
    const dot = document.createElement('span');
    dot.className = 'dot';
    this.shown.push(this.marks.add(point.point, dot));
    if (this.points.length === 2) this.addLabel();
    this.tell();
  }

  addLabel() {
    const [a, b] = this.points;
    const label = document.createElement('span');
    label.className = 'length';
    this.label = this.marks.add(times(add(a.point, b.point), 0.5), label, true);
  }

  // Distance of the two points in the unit; null: there are not two.
  distance() {
    if (this.points.length < 2) return null;
    const {value, deviation} = distanceOf(this.points[0], this.points[1]);
    const {length: factor} = this.unit;
    return {value: value * factor, deviation: deviation === null ? null : deviation * factor};
  }

  tell() {
    const distance = this.distance();
    let words = this.viewer.texts.say(this.points.length === 0 ? 'firstPoint' : 'secondPoint');
    if (distance) words = lengthText(distance.value, distance.deviation, this.unit.name);
    part('measured').textContent = words;
    if (this.label) this.label.element.textContent = words;
  }

  clear() {
    for (const mark of [...this.shown, ...this.label ? [this.label] : []]) this.marks.remove(mark);
    this.points = [];
    this.shown = [];
    this.label = null;
    this.drawLine();
    this.tell();
  }

  // Draws the line between both points, unless one is not before the camera or surface hides both.
  drawLine() {
    const [a, b] = this.shown;
    const isShown = a?.place && b?.place && !(a.hidden && b.hidden);
    this.line.toggleAttribute('hidden', !isShown);
    this.label?.element.classList.toggle('behind', !isShown);
    const {drawn, canvas} = this.viewer;
    if (!isShown || !a.place || !b.place || !drawn) return;
    const across = canvas.clientWidth / drawn.camera.width;
    const down = canvas.clientHeight / drawn.camera.height;
    this.line.setAttribute('d', `M${a.place.x * across} ${a.place.y * down}L${b.place.x * across} ${b.place.y * down}`);
    this.line.classList.toggle('dashed', a.hidden || b.hidden);
  }
}
