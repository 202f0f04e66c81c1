// SPDX-License-Identifier: GPL-3.0-or-later
// Draws small pictures to find out how much of a picture was photographed, and which photographs it needs.
import {scaledCamera} from '../camera.js';
import {Fence, GlObjects} from './gl_objects.js';
import {bindTexture, makeTexture} from './tables.js';
/** @import {Sized} from './gl_objects.js' */
/** @import {Renderer} from './renderer.js' */
/** @import {Camera, Size, View} from '../types.d.ts' */

const READ_AGAIN_MS = 8;
const GLANCE_PX = 48;  // longer side of what is looked at
// Bytes of the targets for a glance: the surface with its depth, and what is found of it.
export const MOST_GLANCE_BYTES = GLANCE_PX * GLANCE_PX * (20 + 16 + 4);
const NO_VIEW = 0xFFFF;
const SPARE_NEED = 1 / 16;  // need of a view that steps in where a better one does not see the place

export class Glances {
  /** @param {Renderer} renderer */
  constructor(renderer) {
    this.renderer = renderer;
    this.gl = renderer.gl;
  }

  // The share of the middle of a surface's picture that was photographed (kept_path.h), in [0, 1]. The middle's width
  // is its height times `aspect`. `camera` is the one that the surface was drawn for. Throws ContextLost.
  /** @param {Sized & {surface: WebGLTexture}} target @param {Camera} camera @param {number} aspect */
  async photographedShare({surface, width, height}, camera, aspect) {
    const {gl, renderer} = this;
    const {photographed} = renderer.scene;
    renderer.setState();
    renderer.describe(camera, [1, 1, 1]);
    const size = [Math.min(width, height * aspect), Math.min(height, width / aspect)];
    const [across, down] = size.map((side) => Math.max(1, Math.round(GLANCE_PX * side / Math.max(...size))));
    /** @type {Size} */
    const steps = [across, down];
    this.begin('glance', gl.RGBA8, steps, surface);
    const program = renderer.programs.use('glance');
    gl.uniform4f(program.uniform('part'), (width - size[0]) / 2, (height - size[1]) / 2,
                 size[0] / steps[0], size[1] / steps[1]);
    gl.uniform1f(program.uniform('least_cosine'), photographed.cosine);
    gl.uniform1f(program.uniform('enlargement'), photographed.enlargement);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const pixels = await this.readLater(steps, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4 * steps[0] * steps[1]));
    let count = 0;
    for (let i = 0; i < pixels.length; i += 4) count += pixels[i] > 0 ? 1 : 0;
    return count / (steps[0] * steps[1]);
  }

  // The same of a stored view's own picture.
  /** @param {View} view */
  async photographedShareOfView(view) {
    const {camera, surface} = this.smallSurface(view);
    return this.photographedShare(surface, camera, camera.width / camera.height);
  }

  // For each view that a camera's picture is made of, by slot, how many of its pixels need it.
  /** @param {Camera} wanted */
  async neededViews(wanted) {
    const {gl, renderer} = this;
    const {camera, surface} = this.smallSurface(wanted);
    /** @type {Size} */
    const steps = [camera.width, camera.height];
    this.begin('needs', gl.RGBA32UI, steps, surface.surface);
    renderer.programs.use('needs');
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const ranked = await this.readLater(
        steps, gl.RGBA_INTEGER, gl.UNSIGNED_INT, new Uint32Array(4 * steps[0] * steps[1]));
    /** @type {Map<number, number>} */
    const needs = new Map();
    const blended = renderer.scene.blend.views;
    new Uint16Array(ranked.buffer).forEach((slot, i) => {
      if (slot !== NO_VIEW) needs.set(slot, (needs.get(slot) ?? 0) + (i % 8 < blended ? 1 : SPARE_NEED));
    });
    return needs;
  }

  // Returns a small picture of a camera's surface, as a target that is valid until the next call.
  /** @param {Camera} wanted */
  smallSurface(wanted) {
    const {renderer} = this;
    const camera = scaledCamera(wanted, GLANCE_PX / Math.max(wanted.width, wanted.height));
    renderer.setState();
    renderer.describe(camera, [1, 1, 1]);
    const surface = renderer.surfaceTarget('small', camera.width, camera.height);
    renderer.drawSurface(surface, false);
    return {camera, surface};
  }

  /** @param {string} use @param {number} format @param {Size} size @param {WebGLTexture} surface */
  begin(use, format, [width, height], surface) {
    const {gl, renderer} = this;
    const target = this.target(use, format, width, height);
    renderer.bindTables();
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.framebuffer);
    gl.viewport(0, 0, width, height);
    bindTexture(gl, 'surfaces', gl.TEXTURE_2D, surface);
  }

  /** @param {string} use @param {number} format @param {number} width @param {number} height */
  target(use, format, width, height) {
    const pixelBytes = format === this.gl.RGBA8 ? 4 : 16;
    return this.renderer.targets.of(use, width, height, pixelBytes, (objects) => ({
      framebuffer: objects.framebuffer(makeTexture(objects, format, width, height)),
    }));
  }

  // The current framebuffer, into `pixels`, without waiting for the GPU. Throws ContextLost.
  /**
   * @template {Uint8Array<ArrayBuffer> | Uint32Array<ArrayBuffer>} Pixels
   * @param {Size} size
   * @param {number} format
   * @param {number} type
   * @param {Pixels} pixels
   */
  async readLater([width, height], format, type, pixels) {
    const {gl} = this;
    const objects = new GlObjects(gl);
    const buffer = objects.buffer();
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    gl.bufferData(gl.PIXEL_PACK_BUFFER, pixels.byteLength, gl.STREAM_READ);
    gl.pixelStorei(gl.PACK_ALIGNMENT, 1);
    gl.readPixels(0, 0, width, height, format, type, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    const fence = new Fence(gl);
    try {
      do {
        await new Promise((resolve) => setTimeout(resolve, READ_AGAIN_MS));
      } while (!fence.passed());
      gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
      gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, pixels);
      gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
      return pixels;
    } finally {
      objects.release();
    }
  }
}
