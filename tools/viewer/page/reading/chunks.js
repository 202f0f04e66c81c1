// SPDX-License-Identifier: GPL-3.0-or-later
// A surface in chunks, each a file of its own: which of them is needed next, and one mesh of those that are there, with
// the coarse surface where others are missing.
import {CELLS_OF_SHADER} from './surface.js';
/** @import {Chunk, ChunkSource, Mesh, MeshFile, Scene, Tables, Vector} from '../types.d.ts' */

// How far a point is from a box (least x, y, z, then most), and from its middle.
/** @param {number[]} box @param {ArrayLike<number>} point */
function distanceTo(box, point) {
  let [outside, middle] = [0, 0];
  for (let axis = 0; axis < 3; ++axis) {
    const [least, most] = [box[axis], box[axis + 3]];
    outside += Math.max(least - point[axis], point[axis] - most, 0) ** 2;
    middle += ((least + most) / 2 - point[axis]) ** 2;
  }
  return {outside, middle};
}

// The number of the box that is nearest to a point; of those around it the one whose middle is. -1: there are none.
/** @param {number[][]} boxes @param {number[]} among @param {ArrayLike<number>} point */
export function nearestBox(boxes, among, point) {
  let best = -1;
  let least = {outside: Infinity, middle: Infinity};
  for (const number of among) {
    const distance = distanceTo(boxes[number], point);
    const nearer = distance.outside !== least.outside ? distance.outside < least.outside :
      distance.middle < least.middle;
    if (best >= 0 && !nearer) continue;
    best = number;
    least = distance;
  }
  return best;
}

// The corners of the faces that are nearest to a box in `missing`.
/** @param {Mesh} mesh @param {number[][]} boxes @param {Set<number>} missing */
function cornersNear({positions, corners}, boxes, missing) {
  const all = boxes.map((_, number) => number);
  const near = [];
  for (let i = 0; i < corners.length; i += 3) {
    const middle = [0, 1, 2].map((axis) => (positions[3 * corners[i] + axis] + positions[3 * corners[i + 1] + axis] +
        positions[3 * corners[i + 2] + axis]) / 3);
    if (missing.has(nearestBox(boxes, all, middle))) near.push(corners[i], corners[i + 1], corners[i + 2]);
  }
  return Uint32Array.from(near);
}

/** @param {number[]} counts */
const startsOf = (counts) => counts.map((_, i) => counts.slice(0, i).reduce((a, b) => a + b, 0));

/** @param {number[]} counts */
const sumOf = (counts) => counts.reduce((a, b) => a + b, 0);

// One mesh of several, whose zones count on from `firstZones`.
/** @param {Mesh[]} meshes @param {number[]} firstZones @returns {Mesh} */
function joinedMesh(meshes, firstZones) {
  const counts = meshes.map(({zones}) => zones.length);
  const firsts = startsOf(counts);
  const vertices = sumOf(counts);
  const joined = {
    positions: new Float32Array(3 * vertices), colors: new Uint8Array(4 * vertices),
    shares: new Uint8Array(4 * vertices), zones: new Uint32Array(vertices),
    corners: new Uint32Array(sumOf(meshes.map(({corners}) => corners.length))),
    counts: CELLS_OF_SHADER.map((_, group) => sumOf(meshes.map((mesh) => mesh.counts[group]))),
  };
  meshes.forEach((mesh, number) => {
    joined.positions.set(mesh.positions, 3 * firsts[number]);
    joined.colors.set(mesh.colors, 4 * firsts[number]);
    joined.shares.set(mesh.shares, 4 * firsts[number]);
    for (let i = 0; i < mesh.zones.length; ++i) joined.zones[firsts[number] + i] = firstZones[number] + mesh.zones[i];
  });
  let at = 0;
  CELLS_OF_SHADER.forEach((_, group) => meshes.forEach((mesh, number) => {
    const first = startsOf(mesh.counts)[group];
    for (let i = first; i < first + mesh.counts[group]; ++i) joined.corners[at++] = firsts[number] + mesh.corners[i];
  }));
  return joined;
}

// One table of several, in the order of joinedMesh(), and a last zone without references.
/** @param {Tables[]} all @returns {Tables} */
function joinedTables(all) {
  const zoneCounts = all.map(({zones}) => zones.length / 4);
  const cellCounts = all.map(({cells}) => cells.length / 3);
  const referenceCounts = all.map(({references}) => references.length);
  const [firstZones, firstCells, firstReferences] = [zoneCounts, cellCounts, referenceCounts].map(startsOf);
  const lastCell = sumOf(cellCounts);
  const joined = {
    zones: new Uint32Array(4 * (sumOf(zoneCounts) + 1)), cells: new Uint32Array(3 * (lastCell + 1)),
    references: new Uint32Array(sumOf(referenceCounts)), resident: all[0].resident,
  };
  all.forEach(({zones, cells, references}, number) => {
    const [zone, cell, reference] = [firstZones[number], firstCells[number], firstReferences[number]];
    for (let i = 0; i < zoneCounts[number]; ++i) {
      const [from, to, own, deviation] = zones.subarray(4 * i, 4 * i + 4);
      joined.zones.set([from + reference, to + reference, own + cell, deviation], 4 * (zone + i));
    }
    for (let i = 0; i < cellCounts[number]; ++i) {
      const [from, to, seen] = cells.subarray(3 * i, 3 * i + 3);
      joined.cells.set([from + reference, to + reference, seen], 3 * (cell + i));
    }
    joined.references.set(references, reference);
  });
  joined.zones.set([0, 0, lastCell, 0], joined.zones.length - 4);
  joined.cells.set([0, 0, 1], 3 * lastCell);
  return joined;
}

// The chunks of a surface. What was read of them is kept until all of them are there.
export class Chunks {
  // `boxes`: where each of the sources' meshes lies.
  /** @param {ChunkSource[]} sources @param {number[][]} boxes */
  constructor(sources, boxes) {
    this.sources = sources;
    this.boxes = boxes;
    /** @type {number | null} */
    this.coarse = null;
    this.kept = false;
    /** @type {(Chunk | null)[]} */
    this.there = sources.map(() => null);
  }

  // The files that hold them, as one name.
  /** @returns {MeshFile} */
  described() {
    const file = this.sources.map(({uri}) => uri).join();
    return {file, colors: file, tables: file, source: this, chunks: this};
  }

  missing() {
    return this.there.flatMap((chunk, number) => chunk ? [] : [number]);
  }

  // Returns the missing chunk that is nearest to a position and not in `tried`; -1: there is none.
  /** @param {Vector} position @param {Set<number>} tried */
  next(position, tried) {
    return nearestBox(this.boxes, this.missing().filter((number) => !tried.has(number)), position);
  }

  /** @param {number} number */
  async load(number) {
    const source = this.sources[number];
    const [mesh, zones] = [await source.mesh(), await source.zoneCount()];
    this.there[number] ??= {mesh, zones, tables: null};
  }

  // Those that are there, and of the coarse mesh, if there is one, what lies where the others would be.
  /** @param {Mesh | null} coarse @returns {Mesh} */
  joined(coarse) {
    const there = this.there.filter((chunk) => chunk !== null);
    const meshes = there.map(({mesh}) => mesh);
    const firstZones = startsOf(there.map(({zones}) => zones));
    const missing = new Set(this.missing());
    if (coarse && missing.size > 0) {
      const corners = cornersNear(coarse, this.boxes, missing);
      const zones = new Uint32Array(coarse.zones.length);
      const counts = CELLS_OF_SHADER.map((_, group) => group === 0 ? corners.length : 0);
      meshes.push({...coarse, zones, corners, counts});
      firstZones.push(sumOf(there.map(({zones}) => zones)));
    }
    return joinedMesh(meshes, firstZones);
  }

  // Returns whether there are tables: the first chunk says which tiles of the photographs are there.
  hasTables() {
    return this.there[0] !== null;
  }

  async mesh() {
    for (const number of this.missing()) await this.load(number);
    return this.joined(null);
  }

  async colors() {
    return (await this.mesh()).colors;
  }

  // Of the chunks that are there.
  /** @param {Scene} scene */
  async tables(scene) {
    await Promise.all(this.there.map(async (chunk, number) => {
      if (!chunk || chunk.tables) return;
      chunk.tables = await this.sources[number].tables(scene);
      await this.sources[number].release();
    }));
    return joinedTables(this.there.flatMap((chunk) => chunk?.tables ? [chunk.tables] : []));
  }

  // Lets go of what was read, once it is all there.
  async release() {
    if (this.missing().length === 0) this.there.fill(null);
  }
}
