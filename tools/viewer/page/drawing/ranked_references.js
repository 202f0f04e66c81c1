// SPDX-License-Identifier: GPL-3.0-or-later
// Orders the references of each zone by the most that they can weigh in a picture, as
// blend/tables/ranked_references.cpp does, so that a pixel looks at the first few and stops.
import {add, dot, length, normalized, poseOf, row, subtract, times} from '../camera.js';
import {Table} from './tables.js';
/** @import {Camera, Mesh, Scene, Tables, Vector} from '../types.d.ts' */

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

// The planes that bound what a camera sees, as their unit normals: view_pyramid() of blend/tables/view_pyramid.h.
/** @param {Camera} camera @returns {Vector[]} */
const pyramidOf = ({fx, fy, cx, cy, width, height}) =>
    [[0, 0, 1], [fx, 0, cx], [-fx, 0, width - cx], [0, fy, cy], [0, -fy, height - cy]].map(normalized);

// The box of each zone's vertices: least and most x, y, z.
/** @param {Mesh} mesh */
export function boxesOfZones({positions, zones}) {
  const count = zones.reduce((most, zone) => Math.max(most, zone + 1), 0);
  const boxes = new Float32Array(6 * count);
  for (let i = 0; i < boxes.length; ++i) boxes[i] = i % 6 < 3 ? Infinity : -Infinity;
  for (let vertex = 0; vertex < zones.length; ++vertex) {
    const box = 6 * zones[vertex];
    for (let axis = 0; axis < 3; ++axis) {
      const value = positions[3 * vertex + axis];
      if (value < boxes[box + axis]) boxes[box + axis] = value;
      if (value > boxes[box + 3 + axis]) boxes[box + 3 + axis] = value;
    }
  }
  return boxes;
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
  return [...lists.values()].map(({from, to, least, most}) => (
    {from, to, center: times(add(least, most), 0.5), radius: length(subtract(most, least)) / 2}));
}

export class RankedReferences {
  // `boxes`: boxesOfZones() of the mesh that is drawn.
  /** @param {WebGL2RenderingContext} gl @param {Tables} tables @param {Float32Array} boxes */
  constructor(gl, {zones, references}, boxes) {
    this.zones = zones;
    this.balls = ballsOf(zones, boxes);
    this.entries = new Uint32Array(2 * references.length);
    this.bounds = new Float32Array(this.entries.buffer);
    references.forEach((reference, i) => {
      this.entries[2 * i] = reference;
      this.bounds[2 * i + 1] = ABOVE_ALL;
    });
    this.table = new Table(gl, this.entries, 2);
    this.ranked = '';  // what the table is ranked for
    /** @type {{scene: Scene | null, centers: (Vector | null)[]}} */
    this.stored = {scene: null, centers: []};
  }

  release() {
    this.table.release();
  }

  /** @param {Float32Array} boxes */
  setBoxes(boxes) {
    this.balls = ballsOf(this.zones, boxes);
    this.ranked = '';
  }

  // Sorts the references of the zones that a camera sees, and copies them to the GPU.
  /** @param {Camera} camera @param {Scene} scene */
  rank(camera, scene) {
    const asked = JSON.stringify(camera);
    if (this.ranked === asked && this.stored.scene === scene) return;
    if (this.stored.scene !== scene) {
      this.stored = {scene, centers: scene.views.map((view) => view && poseOf(view).position)};
    }
    this.ranked = asked;
    const pyramid = pyramidOf(camera);
    const novel = poseOf(camera).position;
    const rows = [0, 1, 2].map((number) => row(camera.rotation, number));
    for (const ball of this.balls) {
      const cam = rows.map((axis, number) => dot(axis, ball.center) + camera.translation[number]);
      if (!pyramid.some((normal) => dot(normal, cam) < -ball.radius)) this.rankZone(ball, novel, scene);
    }
    this.table.store(this.entries, 2);
  }

  /** @param {ZoneBall} ball @param {Vector} novel @param {Scene} scene */
  rankZone(ball, novel, {blend}) {
    const {entries, bounds} = this;
    const {centers} = this.stored;
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
}
