// SPDX-License-Identifier: GPL-3.0-or-later
// Mouse, touch, keyboard and gamepad as movements.
import {normalized} from './camera.js';
import {advanceByGamepad} from './gamepad.js';
/** @import {Navigation} from './navigation.js' */
/** @import {Vector} from './types.d.ts' */

const TURN_PER_HEIGHT = 2.2;  // radians for a drag over the window's height
const WHEEL_SHARE = 0.0012;   // share of the way for each unit of a wheel
const KEY_SPEED = 0.9;        // depths a second
const KEY_TURN = 1.2;         // radians a second
const LONGEST_STEP_S = 0.1;   // limits a step after a slow picture

/** @type {Record<string, Vector>} */
const MOVES = {
  KeyW: [0, 0, 1], KeyS: [0, 0, -1], KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyE: [0, -1, 0], KeyQ: [0, 1, 0],
  PageUp: [0, -1, 0], PageDown: [0, 1, 0],
};
/** @type {Record<string, [number, number]>} */
const TURNS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};

/** @typedef {{x: number, y: number, width: number, height: number}} CanvasPlace */

export class Controls {
  // `pick(x, y)`: depth of the surface at a place of the canvas, in its CSS pixels, or 0. `moved()` is called after
  // each change.
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Navigation} navigation
   * @param {(x: number, y: number) => number} pick
   * @param {() => void} moved
   */
  constructor(canvas, navigation, pick, moved) {
    this.canvas = canvas;
    this.navigation = navigation;
    this.pick = pick;
    this.moved = moved;
    /** @type {Map<number, CanvasPlace>} */
    this.pointers = new Map();
    /** @type {Set<string>} */
    this.keys = new Set();
    const ending = new AbortController();
    const options = {signal: ending.signal};
    this.close = () => ending.abort();
    canvas.addEventListener('pointerdown', (event) => this.pressed(event), options);
    canvas.addEventListener('pointermove', (event) => this.dragged(event), options);
    canvas.addEventListener('pointerup', (event) => this.released(event), options);
    canvas.addEventListener('pointercancel', (event) => this.released(event), options);
    canvas.addEventListener('wheel', (event) => this.wheeled(event), {...options, passive: false});
    canvas.addEventListener('dblclick', (event) => this.doubleClicked(event), options);
    canvas.addEventListener('contextmenu', (event) => event.preventDefault(), options);
    canvas.addEventListener('keydown', (event) => this.keyPressed(event), options);
    canvas.addEventListener('keyup', (event) => this.keys.delete(event.code), options);
    canvas.addEventListener('blur', () => this.keys.clear(), options);
  }

  /** @param {MouseEvent} event @returns {CanvasPlace} */
  place(event) {
    const box = this.canvas.getBoundingClientRect();
    return {x: event.clientX - box.left, y: event.clientY - box.top, width: box.width, height: box.height};
  }

  // In the camera's frame, with z = 1.
  /** @param {CanvasPlace} place @returns {Vector} */
  ray({x, y, width, height}) {
    const tangent = Math.tan(this.navigation.fov * Math.PI / 360) / (height / 2);
    return [(x - width / 2) * tangent, (y - height / 2) * tangent, 1];
  }

  /** @param {PointerEvent} event */
  pressed(event) {
    this.canvas.focus({preventScroll: true});
    try {
      this.canvas.setPointerCapture(event.pointerId);
    } catch {
      // A pointer that is gone already.
    }
    const place = this.place(event);
    this.pointers.set(event.pointerId, place);
    if (this.pointers.size === 1) this.navigation.setDepth(this.pick(place.x, place.y));
  }

  /** @param {PointerEvent} event */
  released(event) {
    this.pointers.delete(event.pointerId);
  }

  /** @param {PointerEvent} event */
  dragged(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const place = this.place(event);
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    this.pointers.set(event.pointerId, place);
    if (others.length === 1) {
      this.pinched(before, place, others[0]);
    } else if (others.length === 0) {
      this.dragBy(place.x - before.x, place.y - before.y, place.height, (event.buttons & 2) !== 0 || event.shiftKey);
    }
    this.moved();
  }

  /** @param {number} dx @param {number} dy @param {number} height @param {boolean} pans */
  dragBy(dx, dy, height, pans) {
    if (pans) {
      const share = 2 * Math.tan(this.navigation.fov * Math.PI / 360) / height;
      this.navigation.move(-dx * share, -dy * share, 0);
    } else {
      this.navigation.turn(TURN_PER_HEIGHT * dx / height, TURN_PER_HEIGHT * dy / height);
    }
  }

  // Two fingers: apart is nearer, along is sideways.
  /** @param {CanvasPlace} before @param {CanvasPlace} place @param {CanvasPlace} other */
  pinched(before, place, other) {
    const apart = (/** @type {CanvasPlace} */ a) => Math.hypot(a.x - other.x, a.y - other.y);
    const share = 1 - apart(before) / Math.max(apart(place), 1);
    this.navigation.approach([0, 0, 1], this.navigation.depth, Math.max(-1, Math.min(0.5, share)));
    this.dragBy((place.x - before.x) / 2, (place.y - before.y) / 2, place.height, true);
  }

  /** @param {WheelEvent} event */
  wheeled(event) {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 30 : 1;
    const place = this.place(event);
    const share = Math.max(-0.5, Math.min(0.5, -event.deltaY * lines * WHEEL_SHARE));
    this.navigation.approach(this.ray(place), this.pick(place.x, place.y), share);
    this.moved();
  }

  // Looks there, and turns about it from then on.
  /** @param {MouseEvent} event */
  doubleClicked(event) {
    const place = this.place(event);
    const depth = this.pick(place.x, place.y);
    if (!(depth > 0)) return;
    const ray = normalized(this.ray(place));
    this.navigation.turn(Math.atan2(ray[0], ray[2]), Math.atan2(ray[1], ray[2]), false);
    this.navigation.setDepth(depth);
    this.moved();
  }

  /** @param {KeyboardEvent} event */
  keyPressed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (!(event.code in MOVES) && !(event.code in TURNS)) return;
    event.preventDefault();
    this.keys.add(event.code);
    this.moved();
  }

  // Moves by the keys and the gamepad that are held, for a time; if nothing is held or touched, by the hold. Returns
  // false if nothing moves.
  /** @param {number} seconds */
  advance(seconds) {
    const step = Math.min(seconds, LONGEST_STEP_S);
    if (advanceByGamepad(this.navigation, step)) return true;
    if (this.keys.size === 0) return this.pointers.size === 0 && this.navigation.relax(step);
    /** @type {[number, number, number]} */
    const move = [0, 0, 0];
    for (const key of this.keys) {
      if (key in MOVES) MOVES[key].forEach((v, axis) => move[axis] += v * KEY_SPEED * step);
      if (key in TURNS) this.navigation.turn(TURNS[key][0] * KEY_TURN * step, TURNS[key][1] * KEY_TURN * step, false);
    }
    this.navigation.move(...move);
    return true;
  }
}
