// SPDX-License-Identifier: GPL-3.0-or-later
// Converts cameras as people who write pages set them: by position, direction, what is up, and angle.
import {length, lookingAlong, row, subtract, times} from '../page/camera.js';
/** @import {Navigation} from '../page/navigation.js' */
/** @import {Pose, Vector} from '../page/types.d.ts' */

const MOST_FOV = 170;  // degrees

/** @typedef {{position: Vector, direction: Vector, up: Vector, fov: number}} ViewerCamera */
/** @typedef {{position?: Vector, direction?: Vector, target?: Vector, up?: Vector, fov?: number}} WantedCamera */

/** @param {Pose} pose @param {number} fov @returns {ViewerCamera} */
export function cameraOf({position, rotation}, fov) {
  return {position: [...position], direction: row(rotation, 2), up: times(row(rotation, 1), -1), fov};
}

/** @param {string} name @param {Vector} value */
function checkVector(name, value) {
  if (value.length === 3 && [...value].every(Number.isFinite)) return;
  throw new RangeError(`the camera's ${name} must be three numbers, is ${JSON.stringify(value)}`);
}

// Returns the pose and the angle of a wanted camera. What it does not say is as the visitor has it; up is what is up in
// the scene. Throws RangeError naming the field that is wrong.
/** @param {WantedCamera} wanted @param {Navigation} navigation */
export function placeOf(wanted, navigation) {
  const {position = navigation.pose.position, fov = navigation.fov, up = navigation.up} = wanted;
  const direction = wanted.direction ?? (wanted.target && subtract(wanted.target, position));
  checkVector('position', position);
  checkVector('up', up);
  if (!(fov > 0 && fov < MOST_FOV)) {
    throw new RangeError(`the camera's fov must be in (0, ${MOST_FOV}) degrees, is ${fov}`);
  }
  if (!direction) return {pose: {position: [...position], rotation: [...navigation.pose.rotation]}, fov};
  checkVector('direction', direction);
  if (!(length(direction) > 0)) throw new RangeError('the target of the camera must differ from its position');
  return {pose: {position: [...position], rotation: lookingAlong(direction, up)}, fov};
}

// Returns the angle from top to bottom at which a photograph fills a picture of that size, and its pose. Throws
// RangeError if the model has no such photograph.
/** @param {string | number} view @param {Navigation} navigation @param {number} width @param {number} height */
export function placeOfView(view, navigation, width, height) {
  const {views} = navigation.scene;
  const slot = typeof view === 'number' ? view : views.findIndex((stored) => stored?.name === view);
  const place = navigation.poseOfView(slot, width, height);
  if (!place) throw new RangeError(`the model has no photograph ${JSON.stringify(view)}`);
  return place;
}

