// SPDX-License-Identifier: GPL-3.0-or-later
// Walking: the camera stays at eye height above the surface, and stops before surface that is in its way.
import {add, dot, length, subtract, times} from './camera.js';
/** @import {Viewer} from './viewer.js' */
/** @import {Vector} from './types.d.ts' */

const KEPT_SHARE = 0.25;     // of the eye height, that the camera keeps from surface before it
const KNEE_SHARE = 0.5;      // of the eye height, below the eyes: what stands this high is in the way
const CLIMB_SHARE = 0.5;     // of the eye height, that the ground may rise or fall at a step
const CLIMB_PART = 0.35;     // part of a rise that is taken with each step, so that stairs are no jolts
const EYE_DEPTHS = 0.5;      // eye height where there is no ground below, in typical depths

export class Walking {
  /** @param {Viewer} viewer */
  constructor(viewer) {
    this.viewer = viewer;
    this.eyeHeight = 0;
    this.isOn = false;
  }

  // Begins at the present height, or ends.
  /** @param {boolean} on */
  turn(on) {
    const {navigation} = this.viewer;
    this.isOn = on;
    navigation.guard = on ? (from, to) => this.step(from, to) : null;
    if (!on) return;
    const ground = this.distance(navigation.pose.position, times(navigation.up, -1));
    this.eyeHeight = ground < Infinity ? ground : EYE_DEPTHS * navigation.typicalDepth;
    if (navigation.orbits) navigation.toggleOrbits();
  }

  // Returns how far the surface is along a direction, which has the length one; Infinity: there is none.
  /** @param {Vector} from @param {Vector} direction */
  distance(from, direction) {
    return this.viewer.distanceAlong(from, direction);
  }

  // Returns where a step from one position to another leads.
  /** @param {Vector} from @param {Vector} to @returns {Vector} */
  step(from, to) {
    const {up} = this.viewer.navigation;
    const wanted = subtract(to, from);
    const level = add(wanted, up, -dot(wanted, up));
    const far = length(level);
    if (far < 1e-3 * length(wanted)) return from;  // straight up or down
    const direction = times(level, 1 / far);
    const knees = add(from, up, -KNEE_SHARE * this.eyeHeight);
    const free = Math.min(this.distance(from, direction), this.distance(knees, direction)) -
        KEPT_SHARE * this.eyeHeight;
    const position = add(from, direction, Math.max(0, Math.min(length(wanted), free)));
    const rise = this.eyeHeight - this.distance(position, times(up, -1));
    return Math.abs(rise) < CLIMB_SHARE * this.eyeHeight ? add(position, up, CLIMB_PART * rise) : position;
  }
}
