// SPDX-License-Identifier: GPL-3.0-or-later
// The exposure of the photographs that were taken near a camera, as blend/exposure.h has it.
import {add, dot, poseOf, row, subtract, times} from '../camera.js';
/** @import {Camera, Scene} from '../types.d.ts' */

const SAME_PLACE = 0.01;  // kSamePlace of blend/exposure.cpp

/** @param {Scene} scene @param {Camera} camera */
export function nearbyExposure(scene, camera) {
  if (!scene.blend.nearby_exposure) return [1, 1, 1];
  const center = poseOf(camera).position;
  const direction = row(camera.rotation, 2);
  let total = 0;
  let sum = [0, 0, 0];
  for (const view of scene.views) {
    if (!view) continue;
    const apart = times(subtract(center, poseOf(view).position), scene.inverse_depth);
    const looksApart = subtract(add(apart, direction), row(view.rotation, 2));
    const weight = 1 / (dot(apart, apart) + dot(looksApart, looksApart) + SAME_PLACE) ** 2;
    total += weight;
    sum = add(sum, view.gain.map(Math.log), weight);
  }
  return total > 0 ? sum.map((v) => Math.exp(-v / total)) : [1, 1, 1];
}
