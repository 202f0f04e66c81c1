// SPDX-License-Identifier: GPL-3.0-or-later
// Compresses photographs on the GPU: a shader draws blocks as whole numbers, which go into a buffer and from there into
// the compressed texture, without a way over the CPU.
import {GlObjects} from './gl_objects.js';
import {BLOCK_SIDE} from './layout.js';
import {makeTexture} from './tables.js';
/** @import {Programs} from './programs.js' */
/** @import {CellPlace, Size, TexelForm} from '../types.d.ts' */

const TEXEL_BLOCK_BYTES = 16;

export class BlockCompressor {
  // For images of at most that size, texels. `form`: see photograph_forms.js.
  /** @param {WebGL2RenderingContext} gl @param {Programs} programs @param {TexelForm} form @param {Size} size */
  constructor(gl, programs, form, [width, height]) {
    this.gl = gl;
    this.programs = programs;
    this.form = form;
    this.objects = new GlObjects(gl);
    const [across, down] = [width, height].map((side) => side / BLOCK_SIDE);
    this.framebuffer = this.objects.framebuffer(makeTexture(this.objects, gl.RGBA32UI, across, down));
    this.buffer = this.objects.buffer();
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, this.buffer);
    gl.bufferData(gl.PIXEL_PACK_BUFFER, TEXEL_BLOCK_BYTES * across * down, gl.STREAM_COPY);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    this.bytes = BlockCompressor.bytesFor([width, height]);
  }

  // On the GPU: what is drawn, and the buffer.
  /** @param {Size} size */
  static bytesFor([width, height]) {
    return 2 * TEXEL_BLOCK_BYTES * (width / BLOCK_SIDE) * (height / BLOCK_SIDE);
  }

  // The photograph and mask that are bound, at a level of a texture array. `pixels`: of the photograph in a texel,
  // along a side.
  /**
   * @param {WebGLTexture} texture
   * @param {number} level
   * @param {CellPlace} place
   * @param {Size} size
   * @param {number} pixels
   */
  store(texture, level, {x, y, page}, [width, height], pixels) {
    const {gl} = this;
    const [across, down] = [width, height].map((side) => side / BLOCK_SIDE);
    const program = this.programs.use(this.form.name);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.viewport(0, 0, across, down);
    gl.uniform1f(program.uniform('pixels'), pixels);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, this.buffer);
    gl.pixelStorei(gl.PACK_ALIGNMENT, 1);
    gl.readPixels(0, 0, across, down, gl.RGBA_INTEGER, gl.UNSIGNED_INT, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, this.buffer);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
    gl.compressedTexSubImage3D(
        gl.TEXTURE_2D_ARRAY, level, x, y, page, width, height, 1, this.form.internal,
        TEXEL_BLOCK_BYTES * across * down, 0);
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, null);
  }

  release() {
    this.objects.release();
  }
}
