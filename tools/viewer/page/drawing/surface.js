// SPDX-License-Identifier: GPL-3.0-or-later
// The surface on the GPU, in pieces that come and go, and the tables that shaders read of it.
import {poseOf} from '../camera.js';
import {Pyramid} from './pyramid.js';
import {SurfacePiece} from './surface_piece.js';
import {TablePool} from './table_pool.js';
import {bindTexture} from './tables.js';
/** @import {Camera, Mesh, Scene, ShownPart, Tables, Vector} from '../types.d.ts' */

export class Surface {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.pools = {zones: new TablePool(gl, 4), cells: new TablePool(gl, 4), references: new TablePool(gl, 2)};
    /** @type {Map<string, SurfacePiece>} */
    this.pieces = new Map();
    /** @type {ShownPart | null} */
    this.shownPart = null;  // of the surface; null: all of it
    /** @type {{scene: Scene | null, centers: (Vector | null)[]}} */
    this.stored = {scene: null, centers: []};
  }

  release() {
    for (const piece of this.pieces.values()) piece.release();
    this.pieces.clear();
    for (const pool of Object.values(this.pools)) pool.release();
  }

  // Puts a mesh in the place of an earlier one of that name, whose tables stay until setTables().
  /** @param {string} name @param {Mesh} mesh */
  setMesh(name, mesh) {
    const before = this.pieces.get(name);
    const piece = new SurfacePiece(this.gl, mesh, this.pools);
    if (before) piece.takeTablesOf(before);
    before?.release();
    piece.setShownPart(this.shownPart);
    this.pieces.set(name, piece);
  }

  /** @param {string} name @param {Tables} tables */
  setTables(name, tables) {
    this.pieces.get(name)?.setTables(tables);
  }

  // Replaces the colours of a mesh's vertices, four bytes each.
  /** @param {string} name @param {Uint8Array<ArrayBuffer>} colors */
  setColors(name, colors) {
    this.pieces.get(name)?.setColors(colors);
  }

  // Gives a piece another name, which none has. Returns whether there is such a piece.
  /** @param {string} before @param {string} name */
  rename(before, name) {
    const piece = this.pieces.get(before);
    if (!piece) return false;
    this.pieces.delete(before);
    this.pieces.set(name, piece);
    return true;
  }

  /** @param {string} name */
  remove(name) {
    this.pieces.get(name)?.release();
    this.pieces.delete(name);
  }

  /** @param {Set<string>} names */
  removeAllBut(names) {
    for (const name of [...this.pieces.keys()]) if (!names.has(name)) this.remove(name);
  }

  // Draws these faces of a mesh alone, a little behind those of others.
  /** @param {string} name @param {Uint32Array<ArrayBuffer>} corners */
  setBehind(name, corners) {
    this.pieces.get(name)?.setBehind(corners, this.shownPart);
  }

  // Bytes on the GPU of a mesh and its tables.
  /** @param {string} name */
  bytesOf(name) {
    return this.pieces.get(name)?.bytesWithTables() ?? 0;
  }

  // Hides the faces whose middles are not in a part of the surface; null: shows all. What is hidden still stands before
  // what photographs show, because it was there when they were taken.
  /** @param {ShownPart | null} part */
  setShownPart(part) {
    this.shownPart = part;
    for (const piece of this.pieces.values()) piece.setShownPart(part);
  }

  // Returns the positions of all vertices.
  positions() {
    const parts = [...this.pieces.values()].map((piece) => piece.positions());
    const all = new Float32Array(parts.reduce((sum, part) => sum + part.length, 0));
    let at = 0;
    for (const part of parts) {
      all.set(part, at);
      at += part.length;
    }
    return all;
  }

  // Returns whether there are pieces, and the tables of all of them.
  hasTables() {
    return this.pieces.size > 0 && [...this.pieces.values()].every((piece) => piece.tables);
  }

  // Returns whether there are faces of one of a piece's `counts`.
  /** @param {number} group */
  has(group) {
    return [...this.pieces.values()].some((piece) => piece.counts[group] > 0);
  }

  // Returns the standard deviation of the surface of a zone along a ray, scene units.
  /** @param {number} zone */
  deviationOf(zone) {
    const bits = new Uint32Array([this.pools.zones.values[4 * zone + 3] << 16]);
    return new Float32Array(bits.buffer)[0];
  }

  // Bytes on the GPU of the meshes and of their tables.
  bytes() {
    let sum = 0;
    for (const piece of this.pieces.values()) sum += piece.bytes;
    for (const pool of Object.values(this.pools)) sum += pool.bytes;
    return sum;
  }

  bindTables() {
    const {gl} = this;
    for (const [name, pool] of Object.entries(this.pools)) bindTexture(gl, name, gl.TEXTURE_2D, pool.table.texture);
  }

  // Returns the pieces of which a camera may see something.
  /** @param {Camera} camera */
  seenBy(camera) {
    const pyramid = new Pyramid(camera);
    return [...this.pieces.values()].filter(({ball}) => pyramid.meets(ball));
  }

  // Sorts the references of the zones that a camera sees, and copies them to the GPU.
  /** @param {Camera} camera @param {Scene} scene */
  rank(camera, scene) {
    if (this.stored.scene !== scene) {
      this.stored = {scene, centers: scene.views.map((view) => view && poseOf(view).position)};
      for (const piece of this.pieces.values()) piece.tables?.references.forget();
    }
    for (const piece of this.seenBy(camera)) piece.tables?.references.rank(camera, this.stored.centers, scene.blend);
  }
}
