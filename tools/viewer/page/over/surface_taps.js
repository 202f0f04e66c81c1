// SPDX-License-Identifier: GPL-3.0-or-later
// Clicks on the surface: a press and a release at one place, by mouse or finger, or Enter for the picture's middle.
import {surfacePointAt} from './surface_points.js';
/** @import {Viewer} from '../viewer.js' */
/** @import {SurfacePoint} from '../types.d.ts' */

const TAP_PX = 6;    // that a pointer may move meanwhile
const TAP_MS = 600;  // that it may be held

export class SurfaceTaps {
  // `taken` is told of each click while it is on: the point; null: there is no surface.
  /** @param {Viewer} viewer @param {(point: SurfacePoint | null) => void} taken */
  constructor(viewer, taken) {
    this.viewer = viewer;
    this.taken = taken;
    this.isOn = false;
    /** @type {{id: number, x: number, y: number, at: number} | null} */
    this.pressed = null;
    const {canvas} = viewer;
    canvas.addEventListener('pointerdown', (event) => this.press(event));
    canvas.addEventListener('pointerup', (event) => this.release(event));
    canvas.addEventListener('keydown', (event) => this.keyPressed(event));
    // Two points that are near each other are no double click.
    canvas.addEventListener('dblclick', (event) => {
      if (this.isOn) event.stopImmediatePropagation();
    }, {capture: true});
  }

  /** @param {boolean} on */
  turn(on) {
    this.isOn = on;
    this.pressed = null;
    document.documentElement.classList.toggle('taps', on);
  }

  /** @param {PointerEvent} event */
  press(event) {
    // A second finger makes it a pinch.
    this.pressed = this.isOn && !this.pressed && event.button === 0 ?
      {id: event.pointerId, x: event.clientX, y: event.clientY, at: performance.now()} : null;
  }

  /** @param {PointerEvent} event */
  release(event) {
    const {pressed} = this;
    this.pressed = null;
    if (!this.isOn || !pressed || pressed.id !== event.pointerId) return;
    if (performance.now() - pressed.at > TAP_MS) return;
    if (Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) > TAP_PX) return;
    const box = this.viewer.canvas.getBoundingClientRect();
    this.taken(surfacePointAt(this.viewer, event.clientX - box.left, event.clientY - box.top));
  }

  /** @param {KeyboardEvent} event */
  keyPressed(event) {
    if (!this.isOn || event.key !== 'Enter' || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const {clientWidth, clientHeight} = this.viewer.canvas;
    this.taken(surfacePointAt(this.viewer, clientWidth / 2, clientHeight / 2));
  }
}
