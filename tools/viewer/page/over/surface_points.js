// SPDX-License-Identifier: GPL-3.0-or-later
// Points of the surface: which one a place of the canvas shows, where the picture shows one, and whether other surface
// hides it.
import {add, dot, partOf, poseOf, row, worldFromCam} from '../camera.js';
/** @import {Viewer} from '../viewer.js' */
/** @import {Camera, SurfacePoint, Vector} from '../types.d.ts' */

const HIDDEN_SHARE = 0.01;  // of a point's depth, by which surface is nearer that hides it

// Returns the surface's point at a place of the canvas, in CSS pixels, as exact as the surface whatever pixels are
// drawn; null: there is none, or only one that is far.
/** @param {Viewer} viewer @param {number} x @param {number} y @returns {SurfacePoint | null} */
export function surfacePointAt(viewer, x, y) {
  if (!viewer.hasMesh || viewer.gl.isContextLost()) return null;
  const {canvas, renderer, size} = viewer;
  const {width, height} = canvas.getBoundingClientRect();
  const [column, line] = [x * size[0] / width - 0.5, y * size[1] / height - 0.5];
  const camera = partOf(viewer.camera(), column, line, 1, 1);
  const {depth, zone} = renderer.surfaceOfPixel(camera);
  if (!(depth > 0 && depth < renderer.scene.depth_before_far)) return null;
  const cam = [(0.5 - camera.cx) / camera.fx * depth, (0.5 - camera.cy) / camera.fy * depth, depth];
  return {
    point: add(poseOf(camera).position, worldFromCam(camera.rotation, cam)),
    deviation: renderer.surface.deviationOf(zone),
  };
}

// Returns where a camera's picture shows a point, in its pixels, and the point's depth; null: it is not before the
// camera.
/** @param {Camera} camera @param {Vector} point */
export function projected({rotation, translation, fx, fy, cx, cy}, point) {
  const [x, y, depth] = [0, 1, 2].map((axis) => dot(row(rotation, axis), point) + translation[axis]);
  return depth > 0 ? {x: fx * x / depth + cx, y: fy * y / depth + cy, depth} : null;
}

// Returns whether surface that is drawn hides a point at a pixel of the last picture: in all pixels around it.
/** @param {Viewer} viewer @param {{x: number, y: number, depth: number}} place */
export function isHidden({renderer, target}, {x, y, depth}) {
  if (!target || x < 0 || y < 0 || x >= target.width || y >= target.height) return false;
  const depths = renderer.depthsAround(target, x, y);
  return depths.every((nearer) => nearer > 0 && nearer < depth * (1 - HIDDEN_SHARE));
}
