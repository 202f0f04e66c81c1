// SPDX-License-Identifier: GPL-3.0-or-later
// Tables that shaders read by number (blend/shaders/tables.glsl), and other textures.
import {poseOf, row, times} from '../camera.js';
import {ContextLost, GlObjects} from './gl_objects.js';
import {unitOf} from './programs.js';
import {TextError} from '../texts/texts.js';
/** @import {Layout, Scene, View} from '../types.d.ts' */

export const TABLE_WIDTH = 2048;  // kTableWidth of blend/gl/gl_objects.h
export const VIEW_TEXELS = 6;     // kViewTexels of blend/tables/view_table.h
export const NO_SLOT = 0xFFFFFFFF;

// A texture with one level. `filter`: NEAREST, or LINEAR for a format that can be filtered.
/**
 * @param {GlObjects} objects
 * @param {number} format
 * @param {number} width
 * @param {number} height
 * @param {number} filter
 */
export function makeTexture(objects, format, width, height, filter = WebGL2RenderingContext.NEAREST) {
  const {gl} = objects;
  const texture = objects.texture();
  gl.activeTexture(gl.TEXTURE0 + SPARE_UNIT);
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  return texture;
}

// Textures are bound to this unit while they are made, so that the shaders keep theirs.
export const SPARE_UNIT = 17;

/**
 * @param {WebGL2RenderingContext} gl
 * @param {string} name
 * @param {number} target
 * @param {WebGLTexture} texture
 */
export function bindTexture(gl, name, target, texture) {
  gl.activeTexture(gl.TEXTURE0 + unitOf(name));
  gl.bindTexture(target, texture);
  gl.activeTexture(gl.TEXTURE0 + SPARE_UNIT);
}

// `values`: `components` an entry, filled up with zeros to the four that a texel has unless there are one or two.
/** @typedef {Uint32Array<ArrayBuffer> | Float32Array<ArrayBuffer>} Values */

export class Table {
  /** @param {WebGL2RenderingContext} gl @param {Values} values @param {number} components */
  constructor(gl, values, components) {
    const real = values instanceof Float32Array;
    this.objects = new GlObjects(gl);
    this.gl = gl;
    this.channels = real || components > 2 ? 4 : components;
    this.entries = values.length / components;
    this.rows = Math.max(1, Math.ceil(this.entries / TABLE_WIDTH));
    if (gl.isContextLost()) throw new ContextLost();
    if (this.rows > gl.getParameter(gl.MAX_TEXTURE_SIZE)) throw new TextError('tableTooLarge');
    const [format, internal] = real ? [gl.RGBA, gl.RGBA32F] : [
      [gl.RED_INTEGER, gl.R32UI], [gl.RG_INTEGER, gl.RG32UI], [], [gl.RGBA_INTEGER, gl.RGBA32UI],
    ][this.channels - 1];
    this.format = format;
    this.type = real ? gl.FLOAT : gl.UNSIGNED_INT;
    this.texture = makeTexture(this.objects, internal, TABLE_WIDTH, this.rows);
    this.bytes = Table.bytesOf(this.entries, this.channels);
    this.store(values, components);
  }

  // Bytes of a table with `entries`, each of 1, 2 or 4 numbers.
  /** @param {number} entries @param {number} channels */
  static bytesOf(entries, channels) {
    return TABLE_WIDTH * Math.max(1, Math.ceil(entries / TABLE_WIDTH)) * 4 * channels;
  }

  release() {
    this.objects.release();
  }

  /** @param {Values} values @param {number} components */
  store(values, components) {
    const width = this.channels;
    const size = TABLE_WIDTH * this.rows * width;
    const padded = values instanceof Float32Array ? new Float32Array(size) : new Uint32Array(size);
    if (width === components) {
      padded.set(values);
    } else {
      for (let i = 0; i < values.length; ++i) padded[Math.floor(i / components) * width + i % components] = values[i];
    }
    this.storeRows(0, this.rows, padded);
  }

  // Replaces whole rows by numbers, as many for each entry as a texel has.
  /** @param {number} first @param {number} rows @param {Values} numbers */
  storeRows(first, rows, numbers) {
    const {gl} = this;
    gl.activeTexture(gl.TEXTURE0 + SPARE_UNIT);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, first, TABLE_WIDTH, rows, this.format, this.type, numbers);
  }
}

// A power of two near what a view looks at; its depths are stored as shares of it.
/** @param {View} view */
export const depthScale = (view) => view.depth > 0 ? 2 ** Math.floor(Math.log2(view.depth)) : 1;

// Does what blend/tables/view_table.cpp does, for views at the layout's scale.
/** @param {Scene} scene @param {Layout} layout */
export function viewTable(scene, layout) {
  const table = new Float32Array(4 * VIEW_TEXELS * scene.views.length);
  scene.views.forEach((view, slot) => {
    const tiles = layout.views[slot];
    if (!view || !tiles) return;
    const s = layout.scale;
    table.set([
      ...times(row(view.rotation, 0), view.fx * s), view.cx * s,
      ...times(row(view.rotation, 1), view.fy * s), view.cy * s,
      ...row(view.rotation, 2), view.fx * s,
      ...poseOf(view).position, depthScale(view),
      view.width * s, view.height * s, tiles.first, tiles.columns,
      ...view.gain, 0,
    ], 4 * VIEW_TEXELS * slot);
  });
  return table;
}
