// SPDX-License-Identifier: GPL-3.0-or-later
// Continues the colours of a picture's surface to where it has none, and fades the surface's end, as the pictures of
// `lumatlas render` do (tools/frame/background.h).
import {bindTexture, makeTexture} from './tables.js';
/** @import {Renderer} from './renderer.js' */
/** @import {Sized} from './gl_objects.js' */
/** @import {Size} from '../types.d.ts' */

const MOST_CELLS = 320;    // along a side of the finest cells
const LEAST_CELL_PX = 4;    // as in background.cpp
const SOFT_SHARE = 0.01;   // of the longer side, over which the surface fades
const MOST_SOFT_CELLS = 4;
const CELL_BYTES = 8;

// Returns the side of the finest cells of a picture, pixels.
/** @param {Size} size */
const cellSide = (size) => Math.max(LEAST_CELL_PX, Math.ceil(Math.max(...size) / MOST_CELLS));

// Returns the bytes of a picture's cells, finest and coarser ones, before and after they are filled.
/** @param {Size} size */
export function surroundingsBytes(size) {
  const [across, down] = size.map((side) => Math.ceil(side / cellSide(size)));
  return 2 * CELL_BYTES * across * down * 4 / 3;
}

/** @typedef {Sized & {cells: WebGLTexture, framebuffer: WebGLFramebuffer}} CellTarget */
/** @typedef {Sized & {colour: WebGLTexture}} Picture */

export class Surroundings {
  /** @param {Renderer} renderer */
  constructor(renderer) {
    this.renderer = renderer;
    this.gl = renderer.gl;
  }

  // Returns cells over a picture, colours and the surface's share, and how many of them are across and down.
  /** @param {Picture} picture */
  of({colour, width, height}) {
    const {gl, renderer: {programs}} = this;
    const cellPx = cellSide([width, height]);
    const softCells = Math.min(MOST_SOFT_CELLS, Math.max(1, SOFT_SHARE * Math.max(width, height) / cellPx));
    let size = [width, height].map((side) => Math.ceil(side / cellPx));
    const gathered = this.target('gathered', 0, size);
    bindTexture(gl, 'image', gl.TEXTURE_2D, colour);
    gl.uniform1i(programs.use('gather').uniform('cell_px'), cellPx);
    this.draw(gathered);
    const levels = [gathered];
    while (Math.max(...size) > 1) {
      size = size.map((side) => Math.ceil(side / 2));
      const half = this.target('gathered', levels.length, size);
      bindTexture(gl, 'fine', gl.TEXTURE_2D, levels[levels.length - 1].cells);
      programs.use('halve');
      this.draw(half);
      levels.push(half);
    }
    this.dropFrom(levels.length);
    let filled = gathered;
    for (let level = levels.length - 1; level >= 0; --level) {
      const fine = levels[level];
      const target = this.target('filled', level, [fine.width, fine.height]);
      const isCoarsest = level === levels.length - 1;
      bindTexture(gl, 'fine', gl.TEXTURE_2D, fine.cells);
      if (!isCoarsest) bindTexture(gl, 'coarse', gl.TEXTURE_2D, filled.cells);
      const program = programs.use('fill');
      gl.uniform1i(program.uniform('is_coarsest'), Number(isCoarsest));
      gl.uniform1f(program.uniform('soft_cells'), level === 0 ? softCells : 0);
      this.draw(target);
      filled = target;
    }
    return {cells: filled.cells, across: [width / cellPx, height / cellPx]};
  }

  // Deletes coarser cells, which a larger picture had.
  /** @param {number} level */
  dropFrom(level) {
    const {targets} = this.renderer;
    for (let coarser = level; targets.get(`gathered ${coarser}`); ++coarser) {
      for (const use of ['gathered', 'filled']) targets.drop(`${use} ${coarser}`);
    }
  }

  /** @param {string} use @param {number} level @param {number[]} size @returns {CellTarget} */
  target(use, level, [width, height]) {
    const {gl} = this;
    return this.renderer.targets.of(`${use} ${level}`, width, height, CELL_BYTES, (objects) => {
      const cells = makeTexture(objects, gl.RG32UI, width, height);
      return {cells, framebuffer: objects.framebuffer(cells)};
    });
  }

  /** @param {CellTarget} target */
  draw({framebuffer, width, height}) {
    const {gl} = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(0, 0, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}
