// SPDX-License-Identifier: GPL-3.0-or-later
// Moves the camera slowly along the photographs of a model until the visitor touches it for the first time. It begins
// once all files are there, and ends where the GPU does not draw interactive frames in time. Where the visitor wants
// less motion, it does not begin.
import {between, dot, length, lookingAlong, poseOf, quaternionOf, row, subtract, times} from './camera.js';
import {isGamepadHeld} from './gamepad.js';
/** @import {Viewer} from './viewer.js' */
/** @import {Pose, View} from './types.d.ts' */

const REST_S = 2;             // that the first picture rests
const DRIFT_SPEED = 0.08;     // typical depths and radians a second
const SPEED_UP_S = 3;         // in which it reaches its speed
const LONGEST_DRIFT_S = 0.1;  // limits a step after a slow picture
const FOLLOW_S = 0.9;         // in which the camera comes near the point that leads it, so that corners are round
const LONGEST_LEG = 2;        // from one photograph to the next, typical depths and radians
const SHORTEST_LEG = 0.02;
const MOST_TURN = 1;          // radians between both, about any axis
const STEEP = 0.95;           // cosine of a view against upwards, from which its picture is not held level
const WELL = 1.1;             // times enough of the picture that was photographed; below, the drift turns back
const KEPT_FREE = 1.1;        // times a leg's length, in which no surface may be
const FORGOTTEN = 8;          // legs, after which a photograph is nearly as good as one that was not visited
const AGAIN = 4;              // times as far counts a photograph that was just visited
const LEAST_PIXELS = 0.5;     // share of an interactive frame's pixels along a side that the GPU must draw in time
const TOUCHES = ['pointerdown', 'wheel', 'keydown', 'touchstart'];

/** @typedef {{slot: number, pose: Pose}} Stop */

// Returns the angle between two rotations, radians.
/** @param {Pose} a @param {Pose} b */
function angleBetween(a, b) {
  const [p, q] = [quaternionOf(a.rotation), quaternionOf(b.rotation)];
  return 2 * Math.acos(Math.min(1, Math.abs(p.reduce((sum, value, i) => sum + value * q[i], 0))));
}

export class Drift {
  // `touched`: what the visitor touches, the window or an element.
  /** @param {Viewer} viewer @param {EventTarget} touched */
  constructor(viewer, touched) {
    this.viewer = viewer;
    /** @type {'waits' | 'drifts' | 'ended'} */
    this.state = 'waits';
    this.changed = () => {};  // after each change of the state
    this.leastPixels = LEAST_PIXELS;
    this.rested = 0;          // seconds in which it could have begun
    this.drifted = 0;         // seconds since it began
    /** @type {Pose} */
    this.pose = viewer.navigation.pose;  // the camera's when it was left alone last
    /** @type {Stop} */
    this.from = {slot: -1, pose: this.pose};
    this.to = this.from;
    this.at = 0;              // how far the point that leads is from `from`
    this.turned = false;      // back on this leg
    /** @type {Map<number, number>} */
    this.visited = new Map(); // for each photograph, the number of the leg that led there
    this.legs = 0;
    /** @type {Set<string>} */
    this.refused = new Set(); // legs on which too little was photographed
    const ending = new AbortController();
    for (const name of TOUCHES) {
      touched.addEventListener(name, () => this.end(), {signal: ending.signal, capture: true, passive: true});
    }
    viewer.closing.signal.addEventListener('abort', () => this.end());
    this.deafen = () => ending.abort();
  }

  // Leaves the camera where it is; the still frame of that place is drawn sharp.
  end() {
    if (this.state === 'ended') return;
    this.state = 'ended';
    this.deafen();
    if (!this.viewer.closing.signal.aborted) this.viewer.moved();
    this.changed();
  }

  // Moves the camera by what it drifts in a time. False: it does not drift.
  /** @param {number} seconds */
  advance(seconds) {
    if (this.state === 'ended') return false;
    const {navigation, sizes} = this.viewer;
    const isLeftAlone = navigation.pose === this.pose && !navigation.jump && !isGamepadHeld();
    if (this.state === 'waits') {
      this.rested = isLeftAlone && this.isReady() ? this.rested + Math.min(seconds, LONGEST_DRIFT_S) : 0;
      this.pose = navigation.pose;
      if (this.rested < REST_S) return false;
      if (!this.begin()) return false;
    } else if (!isLeftAlone || (sizes.measured > 2 && sizes.share < this.leastPixels)) {
      this.end();
      return false;
    }
    this.step(Math.min(seconds, LONGEST_DRIFT_S));
    return this.state === 'drifts';
  }

  isReady() {
    const {viewer} = this;
    if (document.visibilityState !== 'visible') return false;
    if (matchMedia('(prefers-reduced-motion: reduce)').matches) return false;
    if (!viewer.hasMesh || viewer.loading || viewer.losses.any()) return false;
    if (!viewer.shown.pictures || viewer.rests) return false;
    return viewer.mode === 'picture' && viewer.residents.progress().ended && this.isWell();
  }

  // Returns whether enough of the last picture was photographed from near there.
  isWell() {
    const {hold} = this.viewer.navigation;
    return hold.own.size > 0 && hold.share !== null && hold.share >= Math.min(1, WELL * hold.enough());
  }

  begin() {
    this.from = this.to = {slot: -1, pose: this.viewer.navigation.pose};
    if (!this.takeNext()) {
      this.end();
      return false;
    }
    this.state = 'drifts';
    this.changed();
    return true;
  }

  // A point goes from photograph to photograph at an even speed, and the camera follows it.
  /** @param {number} seconds */
  step(seconds) {
    const {viewer} = this;
    const {navigation} = viewer;
    this.drifted += seconds;
    this.at += DRIFT_SPEED * Math.min(1, this.drifted / SPEED_UP_S) * seconds;
    if (!this.isWell()) this.turnBack();
    const far = this.distance(this.from.pose, this.to.pose);
    if (this.at >= far) {
      if (!this.takeNext()) return this.end();
      this.at = 0;
    }
    const whole = this.distance(this.from.pose, this.to.pose);
    const leading = between(this.from.pose, this.to.pose, Math.min(1, this.at / whole));
    navigation.pose = this.pose = between(navigation.pose, leading, 1 - Math.exp(-seconds / FOLLOW_S));
  }

  // Turns on a leg where too little was photographed, once.
  turnBack() {
    if (this.turned) return;
    this.turned = true;
    this.refused.add(this.nameOf(this.from, this.to)).add(this.nameOf(this.to, this.from));
    this.at = Math.max(0, this.distance(this.from.pose, this.to.pose) - this.at);
    [this.from, this.to] = [this.to, this.from];
  }

  /** @param {Stop} from @param {Stop} to */
  nameOf(from, to) {
    return `${from.slot} ${to.slot}`;
  }

  /** @param {Pose} a @param {Pose} b */
  distance(a, b) {
    const {hold} = this.viewer.navigation;
    return hold.distance(a, b);
  }

  // Begins the leg to the best photograph around the last one. False: there is none.
  takeNext() {
    const next = this.nextStop() ?? (this.from.slot >= 0 ? this.from : null);
    if (!next || next === this.to) return false;
    this.from = this.to;
    this.to = next;
    this.turned = false;
    this.visited.set(next.slot, ++this.legs);
    return true;
  }

  // Returns the nearest photograph. Those that were visited lately count as farther, and so do those of which less was
  // photographed well.
  /** @returns {Stop | null} */
  nextStop() {
    const {scene, navigation: {hold}} = this.viewer;
    const own = [...hold.own.values()].sort((a, b) => a - b)[hold.own.size >> 1];
    const stops = scene.views.flatMap((view, slot) => view && slot !== this.to.slot ? [this.stopAt(view, slot)] : []);
    const rated = stops.flatMap((stop) => {
      const far = this.distance(this.to.pose, stop.pose);
      if (far < SHORTEST_LEG || far > LONGEST_LEG || this.refused.has(this.nameOf(this.to, stop))) return [];
      if (angleBetween(this.to.pose, stop.pose) > MOST_TURN) return [];
      const age = this.legs - (this.visited.get(stop.slot) ?? -Infinity);
      const quality = Math.min(1, (hold.own.get(stop.slot) ?? own) / own);
      return [{stop, rating: far * (1 + AGAIN * Math.exp(-age / FORGOTTEN)) / quality}];
    }).sort((a, b) => a.rating - b.rating);
    return rated.find(({stop}) => this.isFree(this.to.pose, stop.pose))?.stop ?? null;
  }

  // Pictures are held level, although photographs need not be.
  /** @param {View} view @param {number} slot @returns {Stop} */
  stopAt(view, slot) {
    const {up} = this.viewer.navigation;
    const {position, rotation} = poseOf(view);
    const forward = row(rotation, 2);
    const isSteep = Math.abs(dot(forward, up)) > STEEP;
    return {slot, pose: {position, rotation: isSteep ? rotation : lookingAlong(forward, up)}};
  }

  // Returns whether no surface stands between two places.
  /** @param {Pose} from @param {Pose} to */
  isFree(from, to) {
    const way = subtract(to.position, from.position);
    const far = length(way);
    if (far === 0) return true;
    return this.viewer.distanceAlong(from.position, times(way, 1 / far)) > KEPT_FREE * far;
  }
}
