// SPDX-License-Identifier: GPL-3.0-or-later
// Mouse, touch and keyboard as movements.
import {add, normalized} from './camera.js';

const TURN_PER_HEIGHT = 2.2;  // radians for a drag over the window's height
const WHEEL_SHARE = 0.0012;   // of the way for each unit of a wheel
const KEY_SPEED = 0.9;        // depths a second
const KEY_TURN = 1.2;         // radians a second
const LONGEST_STEP_S = 0.1;   // so that a slow picture is no leap

const MOVES = {
  KeyW: [0, 0, 1], KeyS: [0, 0, -1], KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyE: [0, -1, 0], KeyQ: [0, 1, 0],
  PageUp: [0, -1, 0], PageDown: [0, 1, 0],
};
const TURNS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};

export class Controls {
  // `pick(x, y)`: depth of the surface at a place of the canvas, in its CSS pixels, or 0. `moved()` is called after
  // each change.
  constructor(canvas, navigation, pick, moved) {
    Object.assign(this, {canvas, navigation, pick, moved});
    this.pointers = new Map();
    this.keys = new Set();
    const listen = (name, handle, options) => {
      canvas.addEventListener(name, (event) => handle.call(this, event), options);
    };
    listen('pointerdown', this.pressed);
    listen('pointermove', this.dragged);
    listen('pointerup', this.released);
    listen('pointercancel', this.released);
    listen('wheel', this.wheeled, {passive: false});
    listen('dblclick', this.doubleClicked);
    listen('contextmenu', (event) => event.preventDefault());
    listen('keydown', this.keyPressed);
    listen('keyup', (event) => this.keys.delete(event.code));
    listen('blur', () => this.keys.clear());
  }

  place(event) {
    const box = this.canvas.getBoundingClientRect();
    return {x: event.clientX - box.left, y: event.clientY - box.top, width: box.width, height: box.height};
  }

  // In the camera's frame, with z = 1.
  ray({x, y, width, height}) {
    const tangent = Math.tan(this.navigation.fov * Math.PI / 360) / (height / 2);
    return [(x - width / 2) * tangent, (y - height / 2) * tangent, 1];
  }

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

  released(event) {
    this.pointers.delete(event.pointerId);
  }

  dragged(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const place = this.place(event);
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    this.pointers.set(event.pointerId, place);
    if (others.length === 1) {
      this.pinched(before, place, others[0]);
    } else if (others.length === 0) {
      this.dragBy(place.x - before.x, place.y - before.y, place.height, event.buttons & 2 || event.shiftKey);
    }
    this.moved();
  }

  dragBy(dx, dy, height, pans) {
    if (pans) {
      const share = 2 * Math.tan(this.navigation.fov * Math.PI / 360) / height;
      this.navigation.move(-dx * share, -dy * share, 0);
    } else {
      this.navigation.turn(TURN_PER_HEIGHT * dx / height, TURN_PER_HEIGHT * dy / height);
    }
  }

  // Two fingers: apart is nearer, along is sideways.
  pinched(before, place, other) {
    const apart = (a) => Math.hypot(a.x - other.x, a.y - other.y);
    const share = 1 - apart(before) / Math.max(apart(place), 1);
    this.navigation.approach([0, 0, 1], this.navigation.depth, Math.max(-1, Math.min(0.5, share)));
    this.dragBy((place.x - before.x) / 2, (place.y - before.y) / 2, place.height, true);
  }

  wheeled(event) {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 30 : 1;
    const place = this.place(event);
    const share = Math.max(-0.5, Math.min(0.5, -event.deltaY * lines * WHEEL_SHARE));
    this.navigation.approach(this.ray(place), this.pick(place.x, place.y), share);
    this.moved();
  }

  // Looks there, and turns about it from then on.
  doubleClicked(event) {
    const place = this.place(event);
    const depth = this.pick(place.x, place.y);
    if (!(depth > 0)) return;
    const ray = normalized(this.ray(place));
    this.navigation.turn(Math.atan2(ray[0], ray[2]), Math.atan2(ray[1], ray[2]), false);
    this.navigation.setDepth(depth);
    this.moved();
  }

  keyPressed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (!(event.code in MOVES) && !(event.code in TURNS)) return;
    event.preventDefault();
    this.keys.add(event.code);
    this.moved();
  }

  // What keys that are held do within a time, or, with no hand on anything, the hold; false: nothing.
  advance(seconds) {
    const step = Math.min(seconds, LONGEST_STEP_S);
    if (this.keys.size === 0) return this.pointers.size === 0 && this.navigation.relax(step);
    let move = [0, 0, 0];
    for (const key of this.keys) {
      if (key in MOVES) move = add(move, MOVES[key], KEY_SPEED * step);
      if (key in TURNS) this.navigation.turn(...TURNS[key].map((v) => v * KEY_TURN * step), false);
    }
    this.navigation.move(...move);
    return true;
  }
}
