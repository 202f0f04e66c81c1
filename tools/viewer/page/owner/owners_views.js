// SPDX-License-Identifier: GPL-3.0-or-later
// Cameras that the owner's file says, or that follow from it.
import {add, length, lookingAlong, rotationOf, row, subtract} from '../camera.js';
/** @import {Navigation} from '../navigation.js' */
/** @import {Annotation, Pose, SavedView} from '../types.d.ts' */

const NEAREST_SHARE = 0.5;  // of the typical depth, from which an annotation without a view is looked at

/** @param {SavedView} view @returns {Pose} */
export const poseOfSaved = ({position, turned}) => ({position: [...position], rotation: rotationOf(turned)});

// Goes to the annotation's view; without one, turns to its point, and comes nearer where it is far.
/** @param {Navigation} navigation @param {Annotation} annotation */
export function flyToAnnotation(navigation, {point, view}) {
  if (view) return navigation.goTo(poseOfSaved(view), view.fov, performance.now());
  const away = subtract(point, navigation.pose.position);
  const distance = length(away);
  const forward = distance > 0 ? away : row(navigation.pose.rotation, 2);
  const near = Math.min(distance, NEAREST_SHARE * navigation.typicalDepth);
  const position = add(point, forward, -near / (distance || 1));
  navigation.goTo({position, rotation: lookingAlong(forward, navigation.up)}, navigation.fov, performance.now());
}
