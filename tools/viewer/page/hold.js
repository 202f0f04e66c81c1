// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps visitors where the scene was photographed: beyond, movements become slow, and the camera comes back once it is
// let go. What counts is how much of the picture was photographed from near there, against what photographs themselves
// show of it (tools/picture/paths/kept_path.h).
import {between, dot, length, row, subtract} from './camera.js';
/** @import {Pose} from './types.d.ts' */

const EASY = 1.2;       // times enough: nothing slows down
const STOP = 0.5;       // times enough: no step leads on
const BACK_S = 0.35;    // in which most of the way back is done
const AT_HOME = 1e-3;   // in depths and radians: the camera has come back

export class Hold {
  // `coveredShare`: of what stored views show, that is enough. `depth`: what moving is weighed by against turning.
  // `nearest`: where the nearest photograph was taken.
  /** @param {number} coveredShare @param {number} depth @param {() => Pose | null} nearest */
  constructor(coveredShare, depth, nearest) {
    this.coveredShare = coveredShare;
    this.depth = depth;
    this.nearest = nearest;
    this.on = true;
    /** @type {Map<number, number>} */
    this.own = new Map();
    /** @type {number | null} */
    this.share = null;
    /** @type {{pose: Pose, share: number} | null} */
    this.inside = null;  // the last place where all was well
    /** @type {Pose | null} */
    this.refuge = null;  // the camera returns here if there was no such place
    this.moved = false;
  }

  // Forgets the places, after a jump or a link: the camera is not called back before the visitor moves it.
  forget() {
    this.share = this.inside = this.refuge = null;
    this.moved = false;
  }

  // The visitor moves the camera.
  noteMove() {
    this.moved = true;
  }

  // Sets what share of a stored view's own picture was photographed.
  /** @param {number} slot @param {number} share */
  setOwn(slot, share) {
    this.own.set(slot, share);
  }

  enough() {
    const own = [...this.own.values()].sort((a, b) => a - b);
    return own.length > 0 ? this.coveredShare * own[own.length >> 1] : 0;
  }

  /** @param {Pose} pose @param {number} share */
  measured(pose, share) {
    this.share = share;
    if (share < EASY * this.enough()) return;
    this.inside = {pose, share};
    this.refuge = null;
  }

  // Returns the pose to which the camera returns; null: none. A place that was good while few photographs were known
  // may not be now.
  home() {
    if (this.inside && this.inside.share >= this.enough()) return this.inside.pose;
    if (this.moved) this.refuge ??= this.nearest();
    return this.refuge;
  }

  outside() {
    return this.on && this.share !== null && this.share < this.enough() && this.home() !== null;
  }

  /** @param {Pose} a @param {Pose} b */
  distance(a, b) {
    const turned = Math.acos(Math.max(-1, Math.min(1, dot(row(a.rotation, 2), row(b.rotation, 2)))));
    return length(subtract(a.position, b.position)) / this.depth + turned;
  }

  // Returns the part of a step that is taken, in [0, 1]: 1, except where the step leads away from home.
  /** @param {Pose} from @param {Pose} to */
  allowed(from, to) {
    const home = this.on && this.share !== null ? this.home() : null;
    if (!home || this.share === null || this.distance(to, home) <= this.distance(from, home)) return 1;
    const enough = this.enough();
    return Math.max(0, Math.min(1, (this.share - STOP * enough) / ((EASY - STOP) * enough || 1)));
  }

  // The pose after some time without a hand on it; null: it may stay.
  /** @param {Pose} pose @param {number} seconds */
  relaxed(pose, seconds) {
    const home = this.outside() ? this.home() : null;
    if (!home || this.distance(pose, home) < AT_HOME) return null;
    const next = between(pose, home, 1 - Math.exp(-seconds / BACK_S));
    return this.distance(next, home) < AT_HOME ? home : next;
  }
}
