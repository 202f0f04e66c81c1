// SPDX-License-Identifier: GPL-3.0-or-later
// Converts three's cameras to those of ../page/camera.js: x right, y down, z forward, pixels from the top left corner.
import {Matrix4, Vector3} from 'three';
/** @import {Camera, Object3D, PerspectiveCamera} from 'three' */
/** @import {Camera as PinholeCamera, Pose, Rotation} from '../page/types.d.ts' */

const UNEVEN = 1e-4;  // share by which an object's scale may differ from axis to axis

// Returns how much longer a length of an object is in the world. Throws RangeError unless the object is only turned,
// moved and scaled evenly.
/** @param {Object3D} object */
export function evenScale({matrixWorld}) {
  const axes = [0, 1, 2].map((axis) => new Vector3().setFromMatrixColumn(matrixWorld, axis));
  const [x, y, z] = axes.map((axis) => axis.length());
  const even = x > 0 && Math.abs(y - x) <= UNEVEN * x && Math.abs(z - x) <= UNEVEN * x;
  const square = Math.abs(axes[0].dot(axes[1])) + Math.abs(axes[1].dot(axes[2])) + Math.abs(axes[0].dot(axes[2]));
  if (!even || !(square <= UNEVEN * x * x) || !(matrixWorld.determinant() > 0)) {
    throw new RangeError('a LumatlasObject may be turned, moved and scaled evenly, but not stretched or mirrored');
  }
  return x;
}

// Returns the pose of a three camera in an object's own coordinates.
/** @param {Camera} camera @param {Object3D} object @returns {Pose} */
export function poseIn(camera, object) {
  const e = new Matrix4().copy(object.matrixWorld).invert().multiply(camera.matrixWorld).elements;
  /** @type {(column: number, sign: number) => Rotation} */
  const axis = (column, sign) => {
    const [x, y, z] = [e[4 * column], e[4 * column + 1], e[4 * column + 2]];
    const length = Math.hypot(x, y, z);
    return [sign * x / length, sign * y / length, sign * z / length];
  };
  return {position: [e[12], e[13], e[14]], rotation: [...axis(0, 1), ...axis(1, -1), ...axis(2, -1)]};
}

// Returns the camera that draws what a three camera sees of an object in a picture of that size.
/** @param {PerspectiveCamera} camera @param {Pose} pose @param {number} width @param {number} height */
export function pinholeOf(camera, pose, width, height) {
  const p = camera.projectionMatrix.elements;
  const {position, rotation: r} = pose;
  /** @type {PinholeCamera} */
  const pinhole = {
    width, height, fx: p[0] * width / 2, fy: p[5] * height / 2,
    cx: (1 - p[8]) * width / 2, cy: (1 + p[9]) * height / 2, rotation: r,
    translation: [0, 3, 6].map((i) => -(r[i] * position[0] + r[i + 1] * position[1] + r[i + 2] * position[2])),
  };
  return pinhole;
}

// Puts a three camera where a pose in an object's own coordinates is.
/** @param {PerspectiveCamera} camera @param {Object3D} object @param {Pose} pose @param {number} fov */
export function placeCamera(camera, object, {position, rotation: r}, fov) {
  const inObject = new Matrix4().set(
      r[0], -r[3], -r[6], position[0], r[1], -r[4], -r[7], position[1], r[2], -r[5], -r[8], position[2], 0, 0, 0, 1);
  const inWorld = inObject.premultiply(object.matrixWorld);
  if (camera.parent) inWorld.premultiply(new Matrix4().copy(camera.parent.matrixWorld).invert());
  inWorld.decompose(camera.position, camera.quaternion, new Vector3());
  camera.fov = fov;
  camera.updateProjectionMatrix();
}
