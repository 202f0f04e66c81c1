// SPDX-License-Identifier: GPL-3.0-or-later
// The coarse meshes that stand in for chunks that are not drawn: that of all chunks, and those of some chunks each,
// where there is room for them. For each chunk the finest one that is there does.
import {CoarseFaces} from '../reading/chunks.js';
/** @import {Surface} from './surface.js' */
/** @import {Chunks} from '../reading/chunks.js' */
/** @import {Mesh, Tables} from '../types.d.ts' */

const OF_ALL = -1;  // the number of the mesh of all chunks

/** @param {number} number */
const nameOf = (number) => `coarse ${number}`;

// Returns the tables of a coarse mesh: all of it is in one zone, which has no references.
/** @type {() => Tables} */
const tablesOfCoarse = () => ({
  zones: new Uint32Array(4), cells: Uint32Array.of(0, 0, 1), references: new Uint32Array(), resident: new Uint32Array(),
});

export class StandIns {
  /** @param {Surface} surface @param {Chunks} chunks */
  constructor(surface, chunks) {
    this.surface = surface;
    this.chunks = chunks;
    /** @type {Map<number, CoarseFaces>} */
    this.there = new Map();
    this.most = 0;  // bytes that one has taken on the GPU
  }

  // Takes the mesh of all chunks, or the one of the stand-in with that number.
  /** @param {Mesh} mesh */
  add(mesh, number = OF_ALL) {
    const {surface, chunks} = this;
    const {first, end} = chunks.standIns[number] ?? {first: 0, end: chunks.boxes.length};
    this.there.set(number, new CoarseFaces(mesh, chunks.boxes.slice(first, end), first));
    surface.setMesh(nameOf(number), {...mesh, zones: new Uint32Array(mesh.zones.length)});
    surface.setTables(nameOf(number), tablesOfCoarse());
    this.most = Math.max(this.most, surface.bytesOf(nameOf(number)));
  }

  /** @param {number} number */
  remove(number) {
    this.there.delete(number);
    this.surface.remove(nameOf(number));
  }

  removeAll() {
    for (const number of [...this.there.keys()]) this.remove(number);
  }

  // Returns the numbers of those that are there, without that of all chunks.
  numbers() {
    return [...this.there.keys()].filter((number) => number !== OF_ALL);
  }

  // Bytes that one takes on the GPU: as many as the largest so far, for they have about as many faces.
  /** @param {number} number */
  bytesOf(number) {
    return this.there.has(number) ? this.surface.bytesOf(nameOf(number)) : this.most;
  }

  // Draws the faces in the places of the chunks that are missing.
  /** @param {(chunk: number) => boolean} isMissing */
  draw(isMissing) {
    const owners = new Int32Array(this.chunks.boxes.length).fill(OF_ALL);
    // Coarser ones have lower numbers.
    for (const number of this.numbers().sort((a, b) => a - b)) {
      const {first, end} = this.chunks.standIns[number];
      owners.fill(number, first, end);
    }
    for (const [number, faces] of this.there) {
      const corners = faces.standingFor((chunk) => owners[chunk] === number && isMissing(chunk));
      this.surface.setBehind(nameOf(number), corners);
    }
  }
}
