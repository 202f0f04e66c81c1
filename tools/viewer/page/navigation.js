// SPDX-License-Identifier: GPL-3.0-or-later
// Where the visitor is, and how movements change that: around a point of the surface, or as one who looks about.
import {Hold} from './hold.js';
import {add, between, dot, length, lookingAlong, normalized, orthonormal, poseOf} from './camera.js';
import {row, subtract, times, turned, worldFromCam} from './camera.js';

const STEEPEST = 0.985;    // of the view against upwards, as a cosine: beyond, left and right would change places
const LEVEL_SHARE = 0.12;  // of a tilt that is taken back with each movement
const JUMP_MS = 700;

export class Navigation {
  constructor(scene) {
    this.follow(scene);
    this.pose = {position: [0, 0, 0], rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1]};
    this.fov = 50;
    this.depth = this.typicalDepth;  // of what movements are about
    this.jump = null;
    this.hold = new Hold(scene.photographed.share, this.typicalDepth);
  }

  // Another version of the scene, which may show better what is up and what it is about.
  follow(scene) {
    this.scene = scene;
    this.up = normalized(scene.up);
    this.typicalDepth = scene.inverse_depth > 0 ? 1 / scene.inverse_depth : 1;
    if (!this.chosen) this.orbits = looksAtOneThing(scene);
  }

  toggleOrbits() {
    this.orbits = !this.orbits;
    this.chosen = true;
  }

  // The point in the middle of the view that one orbits.
  pivot() {
    return add(this.pose.position, row(this.pose.rotation, 2), this.depth);
  }

  set(pose, fov) {
    this.pose = {position: [...pose.position], rotation: orthonormal(pose.rotation)};
    this.fov = fov;
    this.jump = null;
    this.hold.forget();
  }

  // Goes there, or part of the way; returns which.
  step(pose) {
    const part = this.hold.allowed(this.pose, pose);
    this.pose = part === 1 ? pose : between(this.pose, pose, part);
    return part;
  }

  // Comes back from where nobody photographed; false: is not there.
  relax(seconds) {
    if (this.jump || !this.hold.outside()) return false;
    this.pose = this.hold.relaxed(this.pose, seconds);
    return true;
  }

  // A stored photograph fills the window from here, all of it, although the window's middle is its principal point.
  poseOfView(slot, width, height) {
    const view = this.scene.views[slot];
    const right = Math.max(view.cx, view.width - view.cx) / view.fx;
    const down = Math.max(view.cy, view.height - view.cy) / view.fy;
    const focal = Math.min(width / 2 / right, height / 2 / down);
    return {pose: poseOf(view), fov: 2 * Math.atan(height / 2 / focal) * 180 / Math.PI};
  }

  // Goes there, at once or on a way that one can follow.
  goTo(pose, fov, now) {
    this.jump = now === undefined ? null : {from: this.pose, fromFov: this.fov, to: pose, toFov: fov, start: now};
    if (!this.jump) this.set(pose, fov);
  }

  // False once it has arrived.
  advance(now) {
    if (!this.jump) return false;
    const {from, fromFov, to, toFov, start} = this.jump;
    const part = Math.min(1, (now - start) / JUMP_MS);
    const share = part * part * (3 - 2 * part);
    if (part >= 1) {
      this.set(to, toFov);
      return false;
    }
    this.pose = between(from, to, share);
    this.fov = fromFov + (toFov - fromFov) * share;
    return true;
  }

  // Cameras are held level: what is tilted turns back while one moves.
  levelled(rotation) {
    const forward = row(rotation, 2);
    if (Math.abs(dot(forward, this.up)) > STEEPEST) return rotation;
    const level = lookingAlong(forward, this.up);
    if (dot(row(level, 1), row(rotation, 1)) < 0) return rotation;  // upside down on purpose
    return between({position: [0, 0, 0], rotation}, {position: [0, 0, 0], rotation: level}, LEVEL_SHARE).rotation;
  }

  // By radians to the right and downwards; as the eyes do, or around the pivot.
  turn(right, down, orbit = this.orbits) {
    this.jump = null;
    const pivot = this.pivot();
    let rotation = turned(this.pose.rotation, this.up, orbit ? right : -right);
    const tilted = turned(rotation, row(rotation, 0), orbit ? down : -down);
    const steep = (r) => Math.abs(dot(row(r, 2), this.up));
    if (steep(tilted) < STEEPEST || steep(tilted) < steep(rotation)) rotation = tilted;
    rotation = orthonormal(this.levelled(rotation));
    const position = orbit ? add(pivot, row(rotation, 2), -this.depth) : this.pose.position;
    this.step({position, rotation});
  }

  // In the camera's directions, in units of what it looks at.
  move(right, down, forward) {
    this.jump = null;
    const step = worldFromCam(this.pose.rotation, times([right, down, forward], this.depth));
    this.step({...this.pose, position: add(this.pose.position, step)});
  }

  // Towards what a ray meets, by a share of the way.
  approach(ray, depth, share) {
    this.jump = null;
    const way = depth > 0 ? depth : this.depth;
    const nearest = this.typicalDepth * 0.02;
    const step = Math.min(share * way, way - nearest);
    const position = add(this.pose.position, worldFromCam(this.pose.rotation, ray), step);
    this.depth = Math.max(this.depth - step * this.step({...this.pose, position}), nearest);
  }

  setDepth(depth) {
    if (depth > 0) this.depth = depth;
  }

  // Stored views by how near they are to what is seen now, nearest first.
  viewsByDistance() {
    const direction = row(this.pose.rotation, 2);
    const far = (view) => {
      const apart = times(subtract(poseOf(view).position, this.pose.position), 1 / this.typicalDepth);
      const turnedBy = subtract(row(view.rotation, 2), direction);
      return dot(apart, apart) + dot(turnedBy, turnedBy);
    };
    return this.scene.views.map((view, slot) => ({slot, view})).filter(({view}) => view)
        .map(({slot, view}) => ({slot, distance: far(view)})).sort((a, b) => a.distance - b.distance)
        .map(({slot}) => slot);
  }
}

// Whether most cameras look towards each other's middle, as around an object, rather than outwards, as in a room.
function looksAtOneThing(scene) {
  const views = scene.views.filter(Boolean);
  const centers = views.map((view) => poseOf(view).position);
  const middle = times(centers.reduce((a, b) => add(a, b), [0, 0, 0]), 1 / views.length);
  const depth = scene.inverse_depth > 0 ? 1 / scene.inverse_depth : 1;
  const targets = views.map((view, i) => add(centers[i], row(view.rotation, 2), depth));
  const target = times(targets.reduce((a, b) => add(a, b), [0, 0, 0]), 1 / views.length);
  const spread = (points, around) => Math.sqrt(points.reduce((sum, p) => sum + length(subtract(p, around)) ** 2, 0));
  return spread(targets, target) < spread(centers, middle);
}
