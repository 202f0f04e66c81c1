// SPDX-License-Identifier: GPL-3.0-or-later
// Cameras as mesh/camera/camera.h has them: x right, y down, z forward; pixel (0,0) is the top left corner. Here the
// rotation is nine numbers, row by row, that give camera from world coordinates.
/** @import {Camera, Pose, Rotation, Vector} from './types.d.ts' */

/** @param {Vector} a @param {Vector} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @param {Vector} a @param {Vector} b @returns {Vector} */
export const add = (a, b, factor = 1) => [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]];
/** @param {Vector} a @param {Vector} b */
export const subtract = (a, b) => add(a, b, -1);
/** @param {Vector} a @param {number} factor @returns {Vector} */
export const times = (a, factor) => [a[0] * factor, a[1] * factor, a[2] * factor];
/** @param {Vector} a @param {Vector} b @returns {Vector} */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @param {Vector} a */
export const length = (a) => Math.hypot(a[0], a[1], a[2]);
/** @param {Vector} a */
export const normalized = (a) => times(a, 1 / (length(a) || 1));

/** @param {Rotation} rotation @param {number} number @returns {Vector} */
export const row = (rotation, number) => rotation.slice(3 * number, 3 * number + 3);
/** @param {Rotation} rotation @param {Vector} v @returns {Vector} */
export const worldFromCam = (rotation, v) => [0, 1, 2].map(
    (i) => rotation[i] * v[0] + rotation[3 + i] * v[1] + rotation[6 + i] * v[2]);

// Returns the position and orientation of a camera.
/** @param {Camera} camera @returns {Pose} */
export function poseOf(camera) {
  return {position: times(worldFromCam(camera.rotation, camera.translation), -1), rotation: [...camera.rotation]};
}

// `fov` is the angle from the picture's top to its bottom, degrees.
/** @param {Pose} pose @param {number} fov @param {number} width @param {number} height @returns {Camera} */
export function cameraAt(pose, fov, width, height) {
  const focal = height / 2 / Math.tan(fov * Math.PI / 360);
  return {
    width, height, fx: focal, fy: focal, cx: width / 2, cy: height / 2, rotation: pose.rotation,
    translation: [0, 1, 2].map((i) => -dot(row(pose.rotation, i), pose.position)),
  };
}

// The part of a picture that begins at a pixel.
/**
 * @param {Camera} camera
 * @param {number} x
 * @param {number} y
 * @param {number} width
 * @param {number} height
 * @returns {Camera}
 */
export function partOf(camera, x, y, width, height) {
  return {...camera, width, height, cx: camera.cx - x, cy: camera.cy - y};
}

// The same view with `factor` times as many pixels along a side, in a picture that holds it.
/** @param {Camera} camera @param {number} factor @returns {Camera} */
export function scaledCamera(camera, factor) {
  return {
    ...camera, width: Math.ceil(camera.width * factor - 1e-9), height: Math.ceil(camera.height * factor - 1e-9),
    fx: camera.fx * factor, fy: camera.fy * factor, cx: camera.cx * factor, cy: camera.cy * factor,
  };
}

// Turned about an axis of the world, by radians, counterclockwise as seen from the axis' tip.
/** @param {Rotation} rotation @param {Vector} axis @param {number} angle @returns {Rotation} */
export function turned(rotation, axis, angle) {
  const rows = [0, 1, 2].map((i) => rotated(row(rotation, i), axis, angle));
  return [...rows[0], ...rows[1], ...rows[2]];
}

/** @param {Vector} v @param {Vector} axis @param {number} angle */
function rotated(v, axis, angle) {
  const c = Math.cos(angle);
  const s = Math.sin(angle);
  return add(add(times(v, c), cross(axis, v), s), axis, dot(axis, v) * (1 - c));
}

// Rows that are at right angles again after many small turns.
/** @param {Rotation} rotation @returns {Rotation} */
export function orthonormal(rotation) {
  const z = normalized(row(rotation, 2));
  const y0 = row(rotation, 1);
  const y = normalized(add(y0, z, -dot(y0, z)));
  return [...cross(y, z), ...y, ...z];
}

// Looks along `forward` with `up` upwards in the picture.
/** @param {Vector} forward @param {Vector} up @returns {Rotation} */
export function lookingAlong(forward, up) {
  const z = normalized(forward);
  let x = cross(z, up);
  if (length(x) < 1e-6) x = cross(z, Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]);
  x = normalized(x);
  return [...x, ...cross(z, x), ...z];
}

// Unit quaternions x, y, z, w, for addresses and for ways between two rotations.
/** @param {Rotation} r */
export function quaternionOf(r) {
  const w = Math.sqrt(Math.max(0, 1 + r[0] + r[4] + r[8])) / 2;
  if (w > 0.1) return [(r[7] - r[5]) / (4 * w), (r[2] - r[6]) / (4 * w), (r[3] - r[1]) / (4 * w), w];
  const i = r[0] >= r[4] && r[0] >= r[8] ? 0 : r[4] >= r[8] ? 1 : 2;
  const j = (i + 1) % 3;
  const k = (i + 2) % 3;
  const q = [0, 0, 0, 0];
  const size = 2 * Math.sqrt(Math.max(1e-12, 1 + r[4 * i] - r[4 * j] - r[4 * k]));
  q[i] = size / 4;
  q[j] = (r[3 * j + i] + r[3 * i + j]) / size;
  q[k] = (r[3 * k + i] + r[3 * i + k]) / size;
  q[3] = (r[3 * k + j] - r[3 * j + k]) / size;
  return q;
}

/** @param {number[]} quaternion @returns {Rotation} */
export function rotationOf(quaternion) {
  const size = Math.hypot(...quaternion) || 1;
  const [x, y, z, w] = quaternion.map((v) => v / size);
  return [
    1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w), 1 - 2 * (x * x + z * z),
    2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y),
  ];
}

/** @param {Pose} a @param {Pose} b @param {number} share @returns {Pose} */
export function between(a, b, share) {
  let q = quaternionOf(b.rotation);
  const p = quaternionOf(a.rotation);
  if (p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3] < 0) q = q.map((v) => -v);
  return {
    position: add(times(a.position, 1 - share), b.position, share),
    rotation: rotationOf(p.map((v, i) => v * (1 - share) + q[i] * share)),
  };
}
