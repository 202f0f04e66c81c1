// SPDX-License-Identifier: GPL-3.0-or-later
// Orders the references of each zone by the most that they can weigh in a picture, as
// blend/tables/ranked_references.cpp does, so that a pixel looks at the first few and stops.
import {poseOf} from '../camera.js';
import {Pyramid, ballAround} from './pyramid.js';
/** @import {TablePool} from './table_pool.js' */
/** @import {BlendSettings, Camera, Tables, Vector} from '../types.d.ts' */

const ABOVE_ALL = 2;     // a bound above every weight
const ROUNDING = 1e-5;   // kRounding there
const SLOT_MASK = 0x0FFFFFFF;

/** @typedef {{center: Vector, radius: number, from: number, to: number}} ZoneBall */

// An upper bound for a view's weight in a ball: bound_of_weight().
/**
 * @param {{center: Vector, radius: number}} ball
 * @param {Vector} novel
 * @param {Vector} stored
 * @param {{lambda: number, printed_position: boolean}} blend
 */
export function boundOfWeight({center, radius}, novel, stored, {lambda, printed_position: printed}) {
  const [nx, ny, nz] = [novel[0] - center[0], novel[1] - center[1], novel[2] - center[2]];
  const [sx, sy, sz] = [stored[0] - center[0], stored[1] - center[1], stored[2] - center[2]];
  const o = Math.sqrt(nx * nx + ny * ny + nz * nz);
  const i = Math.sqrt(sx * sx + sy * sy + sz * sz);
  const r = radius + ROUNDING * o;
  let direction = 1;
  if (o > r && i > r) {
    const [sineO, sineI] = [r / o, r / i];
    const [cosineO, cosineI] = [Math.sqrt(1 - sineO * sineO), Math.sqrt(1 - sineI * sineI)];
    const sine = sineO * cosineI + cosineO * sineI;
    const cosine = cosineO * cosineI - sineO * sineI;
    const between = (nx * sx + ny * sy + nz * sz) / (o * i);
    if (between < cosine) {
      direction = Math.max(0, between * cosine + Math.sqrt(Math.max(0, 1 - between * between)) * sine);
    }
  }
  const [near, far] = [Math.min(o, i) + r, Math.max(o, i) - r];
  let position = 1;
  if (printed) {
    position = Math.min(1, Math.max(0, 1 - Math.max(0, o - r) / (i + r)));
  } else if (near < far) {
    position = near / far;
  }
  return lambda * direction + (1 - lambda) * position + ROUNDING;
}

// A ball around all zones that have a list of references in common, for each list.
/** @param {Uint32Array} zones @param {Float32Array} boxes @returns {ZoneBall[]} */
function ballsOf(zones, boxes) {
  /** @type {Map<number, {from: number, to: number, least: Vector, most: Vector}>} */
  const lists = new Map();
  for (let zone = 0; 6 * zone < boxes.length && 4 * zone < zones.length; ++zone) {
    const [from, to] = zones.subarray(4 * zone);
    if (from === to || boxes[6 * zone] > boxes[6 * zone + 3]) continue;
    const least = [...boxes.subarray(6 * zone, 6 * zone + 3)];
    const most = [...boxes.subarray(6 * zone + 3, 6 * zone + 6)];
    const known = lists.get(from);
    lists.set(from, known ? {
      from, to, least: known.least.map((value, axis) => Math.min(value, least[axis])),
      most: known.most.map((value, axis) => Math.max(value, most[axis])),
    } : {from, to, least, most});
  }
  return [...lists.values()].map(({from, to, least, most}) => ({from, to, ...ballAround([...least, ...most])}));
}

export class RankedReferences {
  // `boxes`: those of the zones of the mesh that is drawn, least and most x, y, z each.
  /** @param {TablePool} pool @param {Tables} tables @param {Float32Array} boxes */
  constructor(pool, {zones, references}, boxes) {
    this.pool = pool;
    this.zones = zones;
    this.range = pool.take(references.length);
    this.ranked = '';  // what the table is ranked for
    const {entries, bounds} = this.numbers();
    references.forEach((reference, i) => {
      entries[2 * i] = reference;
      bounds[2 * i + 1] = ABOVE_ALL;
    });
    pool.stored(this.range);
    this.balls = ballsOf(zones, boxes);
  }

  release() {
    this.pool.give(this.range);
  }

  // For each reference two numbers: what it refers to, and the bits of its bound.
  numbers() {
    const entries = this.pool.numbers(this.range);
    return {entries, bounds: new Float32Array(entries.buffer, entries.byteOffset, entries.length)};
  }

  /** @param {Float32Array} boxes */
  setBoxes(boxes) {
    this.balls = ballsOf(this.zones, boxes);
    this.forget();
  }

  // Forgets what the table is ranked for.
  forget() {
    this.ranked = '';
  }

  // Sorts the references of the zones that a camera sees, and copies them to the GPU. `centers`: where each of the
  // views was taken.
  /** @param {Camera} camera @param {(Vector | null)[]} centers @param {BlendSettings} blend */
  rank(camera, centers, blend) {
    const asked = JSON.stringify(camera);
    if (this.ranked === asked) return;
    this.ranked = asked;
    const pyramid = new Pyramid(camera);
    const novel = poseOf(camera).position;
    const numbers = this.numbers();
    for (const ball of this.balls) if (pyramid.meets(ball)) rankZone(numbers, ball, novel, centers, blend);
    this.pool.stored(this.range);
  }
}

/**
 * @param {{entries: Uint32Array, bounds: Float32Array}} numbers
 * @param {ZoneBall} ball
 * @param {Vector} novel
 * @param {(Vector | null)[]} centers
 * @param {BlendSettings} blend
 */
function rankZone({entries, bounds}, ball, novel, centers, blend) {
  for (let i = ball.from; i < ball.to; ++i) {
    const entry = entries[2 * i];
    const center = centers[entry & SLOT_MASK];
    const bound = center ? boundOfWeight(ball, novel, center, blend) : 0;
    let at = i;
    for (; at > ball.from && bounds[2 * at - 1] < bound; --at) {
      entries[2 * at] = entries[2 * at - 2];
      bounds[2 * at + 1] = bounds[2 * at - 1];
    }
    entries[2 * at] = entry;
    bounds[2 * at + 1] = bound;
  }
}
