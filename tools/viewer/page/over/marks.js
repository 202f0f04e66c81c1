// SPDX-License-Identifier: GPL-3.0-or-later
// Elements that stand at points of the scene: they follow the picture's camera, and are hidden behind surface.
import {isHidden, projected} from './surface_points.js';
/** @import {Viewer} from '../viewer.js' */
/** @import {Camera, Vector} from '../types.d.ts' */

const LOOKS_A_FRAME = 4;  // marks that are looked for behind surface in each frame

/**
 * @typedef {{
 *   point: Vector,
 *   element: HTMLElement,
 *   through: boolean,
 *   hidden: boolean,
 *   place: {x: number, y: number, depth: number} | null,
 *   looked: object | null,
 * }} Mark
 */

export class Marks {
  // `layer`: the element that lies over the canvas and gets the marks.
  /** @param {Viewer} viewer @param {HTMLElement} layer */
  constructor(viewer, layer) {
    this.viewer = viewer;
    this.layer = layer;
    /** @type {Mark[]} */
    this.all = [];
    this.moved = () => {};  // after marks have moved, or were hidden or shown
    /** @type {object | null} */
    this.drawn = null;      // the picture in which they have their places
    this.size = '';
  }

  // `through`: the mark is seen through surface.
  /** @param {Vector} point @param {HTMLElement} element @returns {Mark} */
  add(point, element, through = false) {
    /** @type {Mark} */
    const mark = {point, element, through, hidden: false, place: null, looked: null};
    element.classList.add('mark');
    this.all.push(mark);
    this.layer.append(element);
    this.drawn = null;
    return mark;
  }

  /** @param {Mark} mark @param {Vector} point */
  move(mark, point) {
    mark.point = point;
    this.drawn = mark.looked = null;
  }

  /** @param {Mark} mark */
  remove(mark) {
    this.all = this.all.filter((other) => other !== mark);
    mark.element.remove();
    this.moved();
  }

  // Called before each frame.
  follow() {
    const {drawn, canvas} = this.viewer;
    const size = `${canvas.clientWidth} ${canvas.clientHeight}`;
    if (!drawn) return;
    if (drawn === this.drawn && size === this.size) {
      if (!this.viewer.fence) this.look();
      return;
    }
    this.drawn = drawn;
    this.size = size;
    for (const mark of this.all) this.place(mark, drawn.camera);
    this.moved();
  }

  /** @param {Mark} mark @param {Camera} camera */
  place(mark, camera) {
    const {canvas} = this.viewer;
    mark.place = projected(camera, mark.point);
    if (mark.place) {
      const x = mark.place.x / camera.width * canvas.clientWidth;
      const y = mark.place.y / camera.height * canvas.clientHeight;
      mark.element.style.transform = `translate(${x}px, ${y}px)`;
    }
    this.show(mark);
  }

  /** @param {Mark} mark */
  show({element, place, hidden}) {
    element.classList.toggle('behind', !place || hidden);
  }

  // Looks for surface before marks. Called when the GPU has finished its work, so that reading depths does not wait.
  look() {
    const {drawn} = this.viewer;
    if (!drawn || drawn !== this.drawn) return;
    const waiting = this.all.filter(({place, through, looked}) => place && !through && looked !== drawn);
    if (waiting.length === 0) return;
    // Those that have waited longest.
    const next = waiting.slice(0, LOOKS_A_FRAME);
    for (const mark of next) {
      mark.looked = drawn;
      mark.hidden = mark.place !== null && isHidden(this.viewer, mark.place);
      this.show(mark);
    }
    this.all = [...this.all.filter((mark) => !next.includes(mark)), ...next];
    this.moved();
  }
}
