// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps visitors where the scene was photographed: beyond, movements become slow, and whoever lets go comes back. What
// counts is how much of the picture was photographed from near there, against what photographs themselves show of it
// (tools/paths/kept_path.h).
import {between, dot, length, row, subtract} from './camera.js';

const EASY = 1.2;       // times enough: nothing slows down
const STOP = 0.5;       // times enough: no step leads on
const BACK_S = 0.35;    // in which most of the way back is done

export class Hold {
  // `covered_share`: of what stored views show, that is enough. `depth`: what moving is weighed by against turning.
  constructor(coveredShare, depth) {
    Object.assign(this, {coveredShare, depth, on: true, own: new Map()});
    this.forget();
  }

  // As after a leap to where nobody is to be called back from.
  forget() {
    this.share = null;
    this.inside = null;  // the last place where all was well
  }

  // Of a stored view's own picture.
  setOwn(slot, share) {
    this.own.set(slot, share);
  }

  enough() {
    const own = [...this.own.values()].sort((a, b) => a - b);
    return own.length > 0 ? this.coveredShare * own[own.length >> 1] : 0;
  }

  measured(pose, share) {
    this.share = share;
    if (share >= EASY * this.enough()) this.inside = pose;
  }

  outside() {
    return this.on && this.inside !== null && this.share !== null && this.share < this.enough();
  }

  distance(a, b) {
    const turned = Math.acos(Math.max(-1, Math.min(1, dot(row(a.rotation, 2), row(b.rotation, 2)))));
    return length(subtract(a.position, b.position)) / this.depth + turned;
  }

  // What is left of a step: all of it but for one that leads away from where all was well.
  allowed(from, to) {
    if (!this.on || !this.inside || this.share === null) return 1;
    if (this.distance(to, this.inside) <= this.distance(from, this.inside)) return 1;
    const enough = this.enough();
    return Math.max(0, Math.min(1, (this.share - STOP * enough) / ((EASY - STOP) * enough || 1)));
  }

  // The pose after some time without a hand on it; the same one where it may stay.
  relaxed(pose, seconds) {
    return this.outside() ? between(pose, this.inside, 1 - Math.exp(-seconds / BACK_S)) : pose;
  }
}
