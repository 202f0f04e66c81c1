// SPDX-License-Identifier: GPL-3.0-or-later
// Where the space of a headset lies in the scene. A headset counts in metres: x right, y up, z backwards.
import {add, cross, dot, length, normalized, rotationOf, row, subtract, times} from '../camera.js';
import {turned, worldFromCam} from '../camera.js';
/** @import {Camera, LengthUnit, Pose, Rotation, Vector} from '../types.d.ts' */

// Metres of units that an owner may name.
/** @type {Record<string, number>} */
const METRES = {m: 1, metre: 1, metres: 1, meter: 1, meters: 1, cm: 0.01, mm: 0.001, km: 1000, in: 0.0254, ft: 0.3048};
const DEPTH_METRES = 2;       // of the typical depth, in a scene whose lengths are not known
const LEAST_LEVEL = 0.1;      // sine of a direction against upwards, from which it says where level is

// Returns how many metres a scene unit is.
/** @param {LengthUnit} unit @param {number} typicalDepth scene units */
export function metresOfUnit(unit, typicalDepth) {
  const known = METRES[unit.name.toLowerCase()];
  return known === undefined ? DEPTH_METRES / typicalDepth : known * unit.length;
}

// Returns the level part of the direction in which a camera looks; of one that looks straight up or down, the level
// part of what is up or down in its picture.
/** @param {Rotation} rotation @param {Vector} up */
function headingOf(rotation, up) {
  const forward = row(rotation, 2);
  const level = add(forward, up, -dot(forward, up));
  if (length(level) > LEAST_LEVEL) return normalized(level);
  const inPicture = times(row(rotation, 1), dot(forward, up) > 0 ? 1 : -1);
  return normalized(add(inPicture, up, -dot(inPicture, up)));
}

// Returns a rotation of a headset's space as this page's cameras have it: camera from that space.
/** @param {DOMPointReadOnly} orientation @returns {Rotation} */
function cameraRotation({x, y, z, w}) {
  const rotation = rotationOf([-x, -y, -z, w]);
  return [...row(rotation, 0), ...times(row(rotation, 1), -1), ...times(row(rotation, 2), -1)];
}

/** @param {DOMPointReadOnly} position @returns {Vector} */
const vectorOf = ({x, y, z}) => [x, y, z];

export class HeadsetPlace {
  // `metres`: length of a scene unit. `up`: upwards in the scene.
  /** @param {number} metres @param {Vector} up */
  constructor(metres, up) {
    this.metres = metres;
    this.up = up;
    this.axes = [1, 0, 0, 0, 1, 0, 0, 0, 1];  // of the headset's space in the scene: right, up, backwards
    /** @type {Vector} */
    this.origin = [0, 0, 0];
  }

  // Lays the space so that the head is where a camera is and faces where it looks, and level is level.
  /** @param {XRRigidTransform} head @param {Pose} pose */
  layAt({position, orientation}, pose) {
    const ahead = headingOf(cameraRotation(orientation), [0, 1, 0]);
    const heading = headingOf(pose.rotation, this.up);
    const side = cross(heading, this.up);
    const right = add(times(heading, ahead[0]), side, -ahead[2]);
    const back = add(times(heading, ahead[2]), side, ahead[0]);
    this.axes = [...right, ...this.up, ...back];
    this.origin = subtract(pose.position, this.inScene(vectorOf(position)));
  }

  // Returns a vector of the headset's space in scene units.
  /** @param {Vector} vector */
  inScene(vector) {
    return times(worldFromCam(this.axes, vector), 1 / this.metres);
  }

  // Returns the pose in the scene of an eye or a head.
  /** @param {XRRigidTransform} transform @returns {Pose} */
  poseOf({position, orientation}) {
    const rotation = cameraRotation(orientation);
    const rows = [0, 1, 2].map((i) => worldFromCam(this.axes, row(rotation, i)));
    return {position: add(this.origin, this.inScene(vectorOf(position))), rotation: rows.flat()};
  }

  // Returns the camera of an eye, for a picture of that size. The frustum of an eye need not be symmetric.
  /** @param {XRView} view @param {number} width @param {number} height @returns {Camera} */
  cameraOf({transform, projectionMatrix: m}, width, height) {
    const {position, rotation} = this.poseOf(transform);
    return {
      width, height, fx: width / 2 * m[0], fy: height / 2 * m[5], cx: width / 2 * (1 - m[8]),
      cy: height / 2 * (1 + m[9]), rotation, translation: [0, 1, 2].map((i) => -dot(row(rotation, i), position)),
    };
  }

  // Moves the space, scene units.
  /** @param {Vector} step */
  move(step) {
    this.origin = add(this.origin, step);
  }

  // Turns the space about a head, to the right by radians.
  /** @param {XRRigidTransform} head @param {number} angle */
  turn({position}, angle) {
    const before = this.inScene(vectorOf(position));
    this.axes = turned(this.axes, this.up, -angle);
    this.origin = add(this.origin, subtract(before, this.inScene(vectorOf(position))));
  }
}
