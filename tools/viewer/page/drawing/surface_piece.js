// SPDX-License-Identifier: GPL-3.0-or-later
// A piece of the surface on the GPU: the whole mesh of a small scene, a chunk of a large one, or the coarse mesh.
import {clusteredFaces} from './clustered_faces.js';
import {GlObjects} from './gl_objects.js';
import {ballAround} from './pyramid.js';
import {RankedReferences} from './ranked_references.js';
import {sortShown} from './shown_faces.js';
/** @import {PoolRange, TablePool} from './table_pool.js' */
/** @import {Mesh, ShownPart, Tables} from '../types.d.ts' */

const NOWHERE = [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];

// The pools that the tables of all pieces are in: see blend/shaders/tables.glsl.
/** @typedef {{zones: TablePool, cells: TablePool, references: TablePool}} TablePools */

// The box of all of a mesh's vertices: least x, y and z, then most.
/** @param {Float32Array} positions */
function boxOf(positions) {
  const box = [...NOWHERE];
  for (let i = 0; i < positions.length; ++i) {
    const axis = i % 3;
    if (positions[i] < box[axis]) box[axis] = positions[i];
    if (positions[i] > box[axis + 3]) box[axis + 3] = positions[i];
  }
  return box;
}

// The box of each zone's vertices: least and most x, y, z.
/** @param {Mesh} mesh */
function boxesOfZones({positions, zones}) {
  const count = zones.reduce((most, zone) => Math.max(most, zone + 1), 0);
  const boxes = new Float32Array(6 * count);
  for (let i = 0; i < boxes.length; ++i) boxes[i] = NOWHERE[i % 6];
  for (let vertex = 0; vertex < zones.length; ++vertex) {
    const box = 6 * zones[vertex];
    for (let axis = 0; axis < 3; ++axis) {
      const value = positions[3 * vertex + axis];
      if (value < boxes[box + axis]) boxes[box + axis] = value;
      if (value > boxes[box + 3 + axis]) boxes[box + 3 + axis] = value;
    }
  }
  return boxes;
}

export class SurfacePiece {
  /** @param {WebGL2RenderingContext} gl @param {Mesh} mesh @param {TablePools} pools */
  constructor(gl, mesh, pools) {
    this.gl = gl;
    this.pools = pools;
    /** @type {GlObjects} */
    this.objects = new GlObjects(gl);
    this.bytes = 0;  // of the mesh
    gl.bindVertexArray(null);
    this.positionBuffer = this.buffer(gl.ARRAY_BUFFER, mesh.positions);
    this.colorBuffer = this.buffer(gl.ARRAY_BUFFER, mesh.colors);
    this.shareBuffer = this.buffer(gl.ARRAY_BUFFER, mesh.shares);
    this.zoneBuffer = this.buffer(gl.ARRAY_BUFFER, mesh.zones);
    this.vertices = this.vertexArray(mesh.corners);
    /** @type {{vertices: WebGLVertexArrayObject, count: number} | null} */
    this.clustered = null;  // fewer faces, in place of all of `counts`, and how many corners they have
    // Numbers of corners: one for each of CELLS_OF_SHADER, the last of faces that are drawn a little behind.
    this.counts = [...mesh.counts, mesh.behind];
    this.shown = this.counts;  // how many of each are shown: the first ones
    this.size = [mesh.positions.length, mesh.corners.length];
    this.ball = ballAround(boxOf(mesh.positions));
    this.zoneBoxes = boxesOfZones(mesh);
    /** @type {{zones: PoolRange, cells: PoolRange, references: RankedReferences} | null} */
    this.tables = null;
  }

  /** @param {number} target @param {ArrayBufferView<ArrayBuffer>} data @returns {WebGLBuffer} */
  buffer(target, data) {
    const {gl} = this;
    const made = this.objects.buffer();
    gl.bindBuffer(target, made);
    gl.bufferData(target, data, gl.STATIC_DRAW);
    this.bytes += data.byteLength;
    return made;
  }

  // Makes a vertex array of faces with these corners.
  /** @param {Uint32Array<ArrayBuffer>} corners */
  vertexArray(corners) {
    const {gl} = this;
    const vertices = this.objects.vertexArray();
    gl.bindVertexArray(vertices);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.positionBuffer);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 12, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.colorBuffer);
    gl.vertexAttribPointer(1, 3, gl.UNSIGNED_BYTE, true, 4, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.shareBuffer);
    gl.vertexAttribPointer(2, 3, gl.UNSIGNED_BYTE, true, 4, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.zoneBuffer);
    gl.vertexAttribIPointer(3, 1, gl.UNSIGNED_INT, 4, 0);
    for (let attribute = 0; attribute < 4; ++attribute) gl.enableVertexAttribArray(attribute);
    this.buffer(gl.ELEMENT_ARRAY_BUFFER, corners);
    gl.bindVertexArray(null);
    return vertices;
  }

  release() {
    this.giveTables();
    this.objects.release();
  }

  giveTables() {
    if (!this.tables) return;
    this.pools.zones.give(this.tables.zones);
    this.pools.cells.give(this.tables.cells);
    this.tables.references.release();
    this.tables = null;
  }

  bytesWithTables() {
    const {pools, tables} = this;
    if (!tables) return this.bytes;
    return this.bytes + pools.zones.bytesOf(tables.zones) + pools.cells.bytesOf(tables.cells) +
        pools.references.bytesOf(tables.references.range);
  }

  // Replaces the tables.
  /** @param {Tables} tables */
  setTables(tables) {
    this.giveTables();
    const {pools} = this;
    const references = new RankedReferences(pools.references, tables, this.zoneBoxes);
    const firstReference = references.range.first;
    const cells = pools.cells.take(tables.cells.length / 3);
    const cellNumbers = pools.cells.numbers(cells);
    for (let cell = 0; 3 * cell < tables.cells.length; ++cell) {
      const [from, to, seen] = tables.cells.subarray(3 * cell, 3 * cell + 3);
      cellNumbers.set([firstReference + from, firstReference + to, seen, 0], 4 * cell);
    }
    pools.cells.stored(cells);
    const zones = pools.zones.take(tables.zones.length / 4);
    const zoneNumbers = pools.zones.numbers(zones);
    for (let zone = 0; 4 * zone < tables.zones.length; ++zone) {
      const [from, to, cell, deviation] = tables.zones.subarray(4 * zone, 4 * zone + 4);
      zoneNumbers.set([firstReference + from, firstReference + to, cells.first + cell, deviation], 4 * zone);
    }
    pools.zones.stored(zones);
    this.tables = {zones, cells, references};
  }

  // The number of the piece's first zone among those of all pieces.
  get firstZone() {
    return this.tables?.zones.first ?? 0;
  }

  // Takes the tables over from a piece whose mesh this one replaces.
  /** @param {SurfacePiece} before */
  takeTablesOf(before) {
    this.tables = before.tables;
    before.tables = null;
    this.tables?.references.setBoxes(this.zoneBoxes);
  }

  // Replaces the colours of the vertices, four bytes each.
  /** @param {Uint8Array<ArrayBuffer>} colors */
  setColors(colors) {
    const {gl} = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.colorBuffer);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, colors);
  }

  // Draws these faces alone, a little behind those of other pieces.
  /** @param {Uint32Array<ArrayBuffer>} corners @param {ShownPart | null} part */
  setBehind(corners, part) {
    const {gl} = this;
    this.counts = this.shown = [...this.counts.slice(0, -1).fill(0), corners.length];
    gl.bindVertexArray(this.vertices);
    gl.bufferSubData(gl.ELEMENT_ARRAY_BUFFER, 0, corners);
    gl.bindVertexArray(null);
    if (part) this.setShownPart(part);
  }

  // Sorts the faces that are shown before those that are hidden, whose middles are not in a part of the surface; null:
  // all are shown.
  /** @param {ShownPart | null} part */
  setShownPart(part) {
    this.shown = this.counts;
    if (!part) return;
    const {gl} = this;
    const corners = new Uint32Array(this.size[1]);
    gl.bindVertexArray(this.vertices);
    gl.getBufferSubData(gl.ELEMENT_ARRAY_BUFFER, 0, corners);
    this.shown = sortShown(this.positions(), corners, this.counts, part);
    gl.bufferSubData(gl.ELEMENT_ARRAY_BUFFER, 0, corners);
    gl.bindVertexArray(null);
  }

  // Returns the positions of the vertices.
  positions() {
    const {gl} = this;
    const positions = new Float32Array(this.size[0]);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.positionBuffer);
    gl.getBufferSubData(gl.ARRAY_BUFFER, 0, positions);
    return positions;
  }

  // Returns the number of faces that are shown.
  faces() {
    return this.shown.reduce((sum, each) => sum + each, 0) / 3;
  }

  // Returns whether all faces are shown, each in its own place.
  get isWhole() {
    const {counts, shown} = this;
    const corners = shown.reduce((sum, each) => sum + each, 0);
    return counts.at(-1) === 0 && corners === this.size[1];
  }

  // Makes the faces that drawClustered() draws.
  makeClustered() {
    const {gl} = this;
    const corners = new Uint32Array(this.size[1]);
    gl.bindVertexArray(this.vertices);
    gl.getBufferSubData(gl.ELEMENT_ARRAY_BUFFER, 0, corners);
    gl.bindVertexArray(null);
    const fewer = clusteredFaces(this.positions(), corners);
    const vertices = fewer === corners ? this.vertices : this.vertexArray(fewer);
    this.clustered = {vertices, count: fewer.length};
  }

  // Draws fewer faces in the place of all. The zone of a face is that of its last corner, and other corners may be in
  // others, so that their shares of cells mean nothing.
  /** @param {WebGLUniformLocation | null} firstZone */
  drawClustered(firstZone) {
    const {gl, clustered} = this;
    if (!clustered || clustered.count === 0) return;
    gl.uniform1ui(firstZone, this.firstZone);
    gl.bindVertexArray(clustered.vertices);
    gl.drawElements(gl.TRIANGLES, clustered.count, gl.UNSIGNED_INT, 0);
  }

  // Draws the faces of one of `counts`. `whole`: with those that are hidden.
  /** @param {number} group @param {boolean} whole @param {WebGLUniformLocation | null} firstZone */
  draw(group, whole, firstZone) {
    const {gl, counts} = this;
    const count = (whole ? counts : this.shown)[group];
    if (!count) return;
    const first = counts.slice(0, group).reduce((sum, each) => sum + each, 0);
    gl.uniform1ui(firstZone, this.firstZone);
    gl.bindVertexArray(this.vertices);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * first);
  }
}
