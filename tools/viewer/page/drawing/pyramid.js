// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds what a camera sees by planes.
import {add, dot, length, normalized, row, subtract, times} from '../camera.js';
/** @import {Camera, Vector} from '../types.d.ts' */

/** @typedef {{center: Vector, radius: number}} Ball */

// Returns the ball around a box: least x, y and z, then most.
/** @param {number[]} box @returns {Ball} */
export function ballAround(box) {
  const [least, most] = [box.slice(0, 3), box.slice(3)];
  return {center: times(add(least, most), 0.5), radius: length(subtract(most, least)) / 2};
}

export class Pyramid {
  /** @param {Camera} camera */
  constructor({rotation, translation, fx, fy, cx, cy, width, height}) {
    this.rows = [0, 1, 2].map((number) => row(rotation, number));
    this.translation = translation;
    // Unit normals, as view_pyramid() of blend/tables/view_pyramid.h has them.
    this.normals = [[0, 0, 1], [fx, 0, cx], [-fx, 0, width - cx], [0, fy, cy], [0, -fy, height - cy]].map(normalized);
  }

  // Returns whether the camera may see something of a ball.
  /** @param {Ball} ball */
  meets({center, radius}) {
    const cam = this.rows.map((axis, number) => dot(axis, center) + this.translation[number]);
    return !this.normals.some((normal) => dot(normal, cam) < -radius);
  }
}
