// SPDX-License-Identifier: GPL-3.0-or-later
// The state that a link restores, as the address after its '#': position, orientation and field of view of the camera,
// and the shown mode. Printing and parsing undo each other up to the seventh digit of a number.
import {quaternionOf, rotationOf} from './camera.js';
/** @import {Mode, Pose} from './types.d.ts' */

/** @type {Mode[]} */
export const MODES = ['picture', 'winner', 'weights', 'coverage', 'geometry', 'colours'];

/** @param {{pose: Pose, fov: number, mode: Mode}} state */
export function printAddress(state) {
  const numbers = (/** @type {number[]} */ list) => list.map((v) => String(Number(v.toPrecision(7)))).join(',');
  let text = `#at=${numbers(state.pose.position)}&turned=${numbers(quaternionOf(state.pose.rotation))}`;
  text += `&fov=${numbers([state.fov])}`;
  return state.mode === 'picture' ? text : `${text}&mode=${state.mode}`;
}

// Null where the text is none of these.
/** @param {string} text */
export function parseAddress(text) {
  const fields = new URLSearchParams(text.replace(/^#/, ''));
  const numbers = (/** @type {string} */ name, /** @type {number} */ count) => {
    const list = (fields.get(name) ?? '').split(',').map(Number);
    return list.length === count && list.every(Number.isFinite) ? list : null;
  };
  const position = numbers('at', 3);
  const quaternion = numbers('turned', 4);
  const fov = numbers('fov', 1);
  if (!position || !quaternion || Math.hypot(...quaternion) < 1e-3) return null;
  if (!fov || !(fov[0] > 0 && fov[0] < 170)) return null;
  const mode = MODES.find((known) => known === fields.get('mode')) ?? 'picture';
  return {pose: {position, rotation: rotationOf(quaternion)}, fov: fov[0], mode};
}
