// SPDX-License-Identifier: GPL-3.0-or-later
// Gamepads as movements: the left stick moves, the right one turns, the triggers go down and up.
/** @import {Navigation} from './navigation.js' */

const STICK_REST = 0.15;      // of a stick's way, within which it rests
const STICK_SPEED = 0.9;      // depths a second
const STICK_TURN = 1.4;       // radians a second
const LEFT_TRIGGER = 6;       // buttons of the standard layout
const RIGHT_TRIGGER = 7;

// Returns how far a stick is moved beyond its rest, in [-1, 1]; finer near the rest.
/** @param {number} value */
export function stickMove(value) {
  const beyond = (Math.abs(value) - STICK_REST) / (1 - STICK_REST);
  return beyond > 0 ? Math.sign(value) * Math.min(1, beyond) ** 2 : 0;
}

const gamepad = () => navigator.getGamepads?.().find((each) => each?.connected && each.mapping === 'standard');

// Returns whether the visitor holds anything of the gamepad.
export function isGamepadHeld() {
  const pad = gamepad();
  return Boolean(pad && (pad.buttons.some(({pressed}) => pressed) || pad.axes.some((value) => stickMove(value) !== 0)));
}

// Moves by what is held of the first gamepad of the standard layout, for a time. Returns false if nothing is held.
/** @param {Navigation} navigation @param {number} seconds */
export function advanceByGamepad(navigation, seconds) {
  const pad = gamepad();
  if (!pad) return false;
  const [right, down, turnRight, turnDown] = [0, 1, 2, 3].map((axis) => stickMove(pad.axes[axis] ?? 0));
  const lower = (pad.buttons[LEFT_TRIGGER]?.value ?? 0) - (pad.buttons[RIGHT_TRIGGER]?.value ?? 0);
  if ([right, down, turnRight, turnDown, lower].every((value) => value === 0)) return false;
  const step = STICK_SPEED * seconds;
  if (turnRight || turnDown) {
    navigation.turn(STICK_TURN * turnRight * seconds, STICK_TURN * turnDown * seconds, false);
  }
  if (right || down || lower) navigation.move(right * step, lower * step, -down * step);
  return true;
}
