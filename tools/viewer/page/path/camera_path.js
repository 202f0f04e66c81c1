// SPDX-License-Identifier: GPL-3.0-or-later
// A camera that moves smoothly through key frames, as tools/picture/paths/camera_path.cpp moves it for videos: cubic
// positions, Bezier curves of turns (Shoemake 1985), Bessel's tangents.
import {add, subtract, times} from '../camera.js';
/** @import {KeyFrame, Vantage, Vector} from '../types.d.ts' */

const MOST_CONTROL_TURN = 1.5;  // kMostControlTurn there, radians

/** @typedef {{position: Vector, turn: Vector, logFocal: number}} PathSpeed */

/** @param {number} fov */
const logFocal = (fov) => -Math.log(Math.tan(fov * Math.PI / 360));
/** @param {number} value */
const fovOfLogFocal = (value) => 2 * Math.atan(Math.exp(-value)) * 180 / Math.PI;

/** @param {number[]} a @param {number[]} b */
const timesQuaternion = ([ax, ay, az, aw], [bx, by, bz, bw]) => [
  aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
  aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz,
];
/** @param {number[]} q */
const conjugate = ([x, y, z, w]) => [-x, -y, -z, w];
/** @param {number[]} q */
const unitQuaternion = (q) => q.map((value) => value / Math.hypot(...q));

// The rotation vector, radians.
/** @param {number[]} q @returns {Vector} */
function logOfQuaternion([x, y, z, w]) {
  const sine = Math.hypot(x, y, z);
  return times([x, y, z], sine > 1e-12 ? 2 * Math.atan2(sine, w) / sine : 2);
}

/** @param {Vector} turn */
function expOfTurn(turn) {
  const half = Math.hypot(...turn) / 2;
  return unitQuaternion([...times(turn, half > 1e-9 ? Math.sin(half) / (2 * half) : 0.5), Math.cos(half)]);
}

// Returns that one of the two quaternions of a turn which is nearer to another.
/** @param {number[]} q @param {number[]} to */
const nearerQuaternion = (q, to) => q.reduce((sum, value, i) => sum + value * to[i], 0) < 0 ? q.map((v) => -v) : q;

/** @param {number[]} from @param {number[]} to @param {number} share */
const partOfTurn = (from, to, share) => unitQuaternion(timesQuaternion(
    expOfTurn(times(logOfQuaternion(timesQuaternion(to, conjugate(from))), share)), from));

/** @param {number[][]} control @param {number} share */
function bezierTurn(control, share) {
  let points = control;
  while (points.length > 1) points = points.slice(1).map((to, i) => partOfTurn(points[i], to, share));
  return points[0];
}

// The cubic with these values and speeds at its ends.
/** @param {Vector} from @param {Vector} speed @param {Vector} to @param {Vector} toSpeed @param {number} share */
function cubic(from, speed, to, toSpeed, share) {
  const rest = 1 - share;
  return from.map((value, i) => value * (rest * rest * (1 + 2 * share)) + speed[i] * (rest * rest * share) +
      to[i] * (share * share * (1 + 2 * rest)) - toSpeed[i] * (share * share * rest));
}

// Speeds between two key frames, per second.
/** @param {KeyFrame} a @param {KeyFrame} b @returns {PathSpeed} */
function speedBetween(a, b) {
  const seconds = b.time - a.time;
  const turned = timesQuaternion(nearerQuaternion(b.vantage.turned, a.vantage.turned), conjugate(a.vantage.turned));
  return {
    position: times(subtract(b.vantage.position, a.vantage.position), 1 / seconds),
    turn: times(logOfQuaternion(turned), 1 / seconds),
    logFocal: (logFocal(b.vantage.fov) - logFocal(a.vantage.fov)) / seconds,
  };
}

/** @param {Vector} v @param {number} most */
function atMost(v, most) {
  const size = Math.hypot(...v);
  return size > most ? times(v, most / size) : v;
}

export class CameraPath {
  // `keys`: at least one, whose times ascend.
  /** @param {KeyFrame[]} keys */
  constructor(keys) {
    this.keys = keys;
    /** @type {PathSpeed[]} */
    this.speeds = keys.map((_, i) => this.speedAt(i));
  }

  /** @param {number} i @returns {PathSpeed} */
  speedAt(i) {
    const {keys} = this;
    const last = keys.length - 1;
    if (last === 0) return {position: [0, 0, 0], turn: [0, 0, 0], logFocal: 0};
    if (i === 0 || i === last) return speedBetween(keys[Math.max(0, i - 1)], keys[Math.min(last, Math.max(1, i))]);
    const before = keys[i].time - keys[i - 1].time;
    const after = keys[i + 1].time - keys[i].time;
    const weight = before / (before + after);
    const [a, b] = [speedBetween(keys[i - 1], keys[i]), speedBetween(keys[i], keys[i + 1])];
    const mix = (/** @type {Vector} */ from, /** @type {Vector} */ to) => add(times(from, 1 - weight), to, weight);
    return {
      position: mix(a.position, b.position),
      turn: atMost(mix(a.turn, b.turn), 3 * MOST_CONTROL_TURN / Math.max(before, after)),
      logFocal: a.logFocal * (1 - weight) + b.logFocal * weight,
    };
  }

  end() {
    return this.keys[this.keys.length - 1].time;
  }

  // Before the first key frame it is there, and after the last.
  /** @param {number} time @returns {Vantage} */
  at(time) {
    const {keys, speeds} = this;
    if (!(time > keys[0].time)) return keys[0].vantage;
    if (time >= this.end()) return keys[keys.length - 1].vantage;
    const i = keys.findIndex((key) => key.time > time) - 1;
    const [a, b] = [keys[i], keys[i + 1]];
    const seconds = b.time - a.time;
    const share = (time - a.time) / seconds;
    const from = a.vantage.turned;
    const to = nearerQuaternion(b.vantage.turned, from);
    return {
      position: cubic(a.vantage.position, times(speeds[i].position, seconds), b.vantage.position,
                      times(speeds[i + 1].position, seconds), share),
      turned: bezierTurn([
        from, timesQuaternion(expOfTurn(times(speeds[i].turn, seconds / 3)), from),
        timesQuaternion(expOfTurn(times(speeds[i + 1].turn, -seconds / 3)), to), to,
      ], share),
      fov: fovOfLogFocal(cubic([logFocal(a.vantage.fov)], [speeds[i].logFocal * seconds], [logFocal(b.vantage.fov)],
                               [speeds[i + 1].logFocal * seconds], share)[0]),
    };
  }
}

// Returns the file that `lumatlas render --path` reads. `offset`: of its positions from the model's.
/** @param {KeyFrame[]} keys @param {Vector} offset */
export function printPath(keys, offset) {
  const lines = keys.map(({time, vantage: {position, turned: [x, y, z, w], fov}}) =>
    ` ${JSON.stringify({time, position: add(position, offset), rotation: [w, x, y, z], fov})}`);
  return `{"keys": [\n${lines.join(',\n')}\n]}\n`;
}
