// SPDX-License-Identifier: GPL-3.0-or-later
// The visitor's pose, and how movements change it: around a point of the surface, or looking about.
import {Hold} from './hold.js';
import {add, between, dot, length, lookingAlong, normalized, orthonormal, poseOf} from './camera.js';
import {row, subtract, times, turned, worldFromCam} from './camera.js';
import {viewsOf} from './reading/model.js';
/** @import {Pose, Rotation, Scene, Vector} from './types.d.ts' */

const STEEPEST = 0.985;    // cosine of the view against upwards: beyond, left and right would change places
const LEVEL_SHARE = 0.12;  // share of a tilt that is taken back with each movement
const JUMP_MS = 700;

export class Navigation {
  /** @param {Scene} scene */
  constructor(scene) {
    this.scene = scene;
    /** @type {Vector | null} */
    this.ownUp = null;  // upwards in place of what the scene says
    this.up = normalized(scene.up);
    this.typicalDepth = 1;
    this.orbits = false;
    this.chosen = false;  // the visitor has said whether it orbits
    this.follow(scene);
    /** @type {Pose} */
    this.pose = {position: [0, 0, 0], rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1]};
    this.fov = 50;
    this.depth = this.typicalDepth;  // distance of the point that movements are about
    /** @type {{from: Pose, fromFov: number, to: Pose, toFov: number, start: number, ms: number} | null} */
    this.jump = null;
    /** @type {((from: Vector, to: Vector) => Vector) | null} */
    this.guard = null;  // says where a movement leads, of those that go sideways or forward
    this.hold = new Hold(scene.photographed.share, this.typicalDepth, () => this.nearestPhotograph());
  }

  // Another version of the scene, which may show better what is up and what it is about.
  /** @param {Scene} scene */
  follow(scene) {
    this.scene = scene;
    this.setUp(this.ownUp);
    this.typicalDepth = scene.inverse_depth > 0 ? 1 / scene.inverse_depth : 1;
    if (!this.chosen) this.orbits = looksAtOneThing(scene);
  }

  // Sets what is upwards; null: as the scene says.
  /** @param {Vector | null} up */
  setUp(up) {
    this.ownUp = up;
    this.up = normalized(up ?? this.scene.up);
  }

  toggleOrbits() {
    this.orbits = !this.orbits;
    this.chosen = true;
  }

  // The point in the middle of the view that one orbits.
  pivot() {
    return add(this.pose.position, row(this.pose.rotation, 2), this.depth);
  }

  /** @param {Pose} pose @param {number} fov */
  set(pose, fov) {
    this.pose = {position: [...pose.position], rotation: orthonormal(pose.rotation)};
    this.fov = fov;
    this.jump = null;
    this.hold.forget();
  }

  // Goes there, or part of the way; returns which.
  /** @param {Pose} pose */
  step(pose) {
    this.hold.noteMove();
    const part = this.hold.allowed(this.pose, pose);
    this.pose = part === 1 ? pose : between(this.pose, pose, part);
    return part;
  }

  // Comes back from where no photograph was taken; false: the pose stays.
  /** @param {number} seconds */
  relax(seconds) {
    const pose = this.jump ? null : this.hold.relaxed(this.pose, seconds);
    this.pose = pose ?? this.pose;
    return pose !== null;
  }

  // Returns the pose of the nearest photograph; null: there is none.
  nearestPhotograph() {
    const [slot] = this.viewsByDistance();
    const view = slot === undefined ? null : this.scene.views[slot];
    return view ? poseOf(view) : null;
  }

  // A stored photograph fills the window from here, all of it, although the window's middle is its principal point.
  // Null: there is no such view.
  /** @param {number} slot @param {number} width @param {number} height */
  poseOfView(slot, width, height) {
    const view = this.scene.views[slot];
    if (!view) return null;
    const right = Math.max(view.cx, view.width - view.cx) / view.fx;
    const down = Math.max(view.cy, view.height - view.cy) / view.fy;
    const focal = Math.min(width / 2 / right, height / 2 / down);
    return {pose: poseOf(view), fov: 2 * Math.atan(height / 2 / focal) * 180 / Math.PI};
  }

  // Goes there, at once or on a way of `ms` milliseconds that one can follow.
  /** @param {Pose} pose @param {number} fov @param {number} [now] */
  goTo(pose, fov, now, ms = JUMP_MS) {
    this.jump = now === undefined ? null : {from: this.pose, fromFov: this.fov, to: pose, toFov: fov, start: now, ms};
    if (!this.jump) this.set(pose, fov);
  }

  // Moves on along a jump; true: the pose has changed.
  /** @param {number} now */
  advance(now) {
    if (!this.jump) return false;
    const {from, fromFov, to, toFov, start, ms} = this.jump;
    const part = Math.max(0, Math.min(1, (now - start) / ms));
    const share = part * part * (3 - 2 * part);
    if (part >= 1) {
      this.set(to, toFov);
    } else {
      this.pose = between(from, to, share);
      this.fov = fromFov + (toFov - fromFov) * share;
    }
    return true;
  }

  // Cameras are held level: what is tilted turns back while one moves.
  /** @param {Rotation} rotation */
  levelled(rotation) {
    const forward = row(rotation, 2);
    if (Math.abs(dot(forward, this.up)) > STEEPEST) return rotation;
    const level = lookingAlong(forward, this.up);
    if (dot(row(level, 1), row(rotation, 1)) < 0) return rotation;  // upside down on purpose
    return between({position: [0, 0, 0], rotation}, {position: [0, 0, 0], rotation: level}, LEVEL_SHARE).rotation;
  }

  // Turns by radians to the right and downwards, as the eyes do, or around the pivot.
  /** @param {number} right @param {number} down @param {boolean} orbit */
  turn(right, down, orbit = this.orbits) {
    this.jump = null;
    const pivot = this.pivot();
    let rotation = turned(this.pose.rotation, this.up, orbit ? right : -right);
    const tilted = turned(rotation, row(rotation, 0), orbit ? down : -down);
    const steep = (/** @type {Rotation} */ r) => Math.abs(dot(row(r, 2), this.up));
    if (steep(tilted) < STEEPEST || steep(tilted) < steep(rotation)) rotation = tilted;
    rotation = orthonormal(this.levelled(rotation));
    const position = orbit ? add(pivot, row(rotation, 2), -this.depth) : this.pose.position;
    this.step({position, rotation});
  }

  /** @param {Vector} position */
  guarded(position) {
    return this.guard ? this.guard(this.pose.position, position) : position;
  }

  // In the camera's directions, in units of what it looks at.
  /** @param {number} right @param {number} down @param {number} forward */
  move(right, down, forward) {
    this.jump = null;
    const step = worldFromCam(this.pose.rotation, times([right, down, forward], this.depth));
    this.step({...this.pose, position: this.guarded(add(this.pose.position, step))});
  }

  // Towards what a ray meets, by a share of the way.
  /** @param {Vector} ray @param {number} depth @param {number} share */
  approach(ray, depth, share) {
    this.jump = null;
    const way = depth > 0 ? depth : this.depth;
    const nearest = this.typicalDepth * 0.02;
    const step = Math.min(share * way, way - nearest);
    const position = this.guarded(add(this.pose.position, worldFromCam(this.pose.rotation, ray), step));
    this.depth = Math.max(this.depth - step * this.step({...this.pose, position}), nearest);
  }

  /** @param {number} depth */
  setDepth(depth) {
    if (depth > 0) this.depth = depth;
  }

  // Stored views by how near they are to what is seen now, nearest first.
  viewsByDistance() {
    const direction = row(this.pose.rotation, 2);
    return this.scene.views.flatMap((view, slot) => {
      if (!view) return [];
      const apart = times(subtract(poseOf(view).position, this.pose.position), 1 / this.typicalDepth);
      const turnedBy = subtract(row(view.rotation, 2), direction);
      return [{slot, distance: dot(apart, apart) + dot(turnedBy, turnedBy)}];
    }).sort((a, b) => a.distance - b.distance).map(({slot}) => slot);
  }
}

// Returns whether most cameras look towards each other's middle, as around an object, rather than outwards, as in a
// room.
/** @param {Scene} scene */
function looksAtOneThing(scene) {
  const views = viewsOf(scene);
  const centers = views.map((view) => poseOf(view).position);
  const middle = times(centers.reduce((a, b) => add(a, b), [0, 0, 0]), 1 / views.length);
  const depth = scene.inverse_depth > 0 ? 1 / scene.inverse_depth : 1;
  const targets = views.map((view, i) => add(centers[i], row(view.rotation, 2), depth));
  const target = times(targets.reduce((a, b) => add(a, b), [0, 0, 0]), 1 / views.length);
  const spread = (/** @type {Vector[]} */ points, /** @type {Vector} */ around) =>
      Math.sqrt(points.reduce((sum, p) => sum + length(subtract(p, around)) ** 2, 0));
  return spread(targets, target) < spread(centers, middle);
}
