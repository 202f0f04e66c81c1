// SPDX-License-Identifier: GPL-3.0-or-later
// A surface in chunks, each a file of its own: which of them is needed next, and one mesh of those that are there, with
// the coarse surface where others are missing.
import {CELLS_OF_SHADER} from './surface.js';
/** @import {Chunk, ChunkSource, Mesh, MeshFile, Scene, Tables, Vector} from '../types.d.ts' */

// Returns the squared distances of a point from a box (least x, y, z, then most) and from the box's middle.
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

// Returns the number of the box that is nearest to a point, or -1 without boxes. Of boxes at the same distance, it
// takes the one whose middle is nearest.
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

// Returns whether a face may be one of the mesh in a box: whether its own box meets that.
/** @param {Float32Array} positions @param {Uint32Array} face @param {number[]} box */
function meets(positions, face, box) {
  for (let axis = 0; axis < 3; ++axis) {
    const [a, b, c] = [positions[3 * face[0] + axis], positions[3 * face[1] + axis], positions[3 * face[2] + axis]];
    if (Math.max(a, b, c) < box[axis] || Math.min(a, b, c) > box[axis + 3]) return false;
  }
  return true;
}

// Returns the corners of the faces that meet a box of `missing`, or to whose first vertex such a box is nearest.
/** @param {Mesh} mesh @param {number[][]} boxes @param {Set<number>} missing */
function cornersNear({positions, corners}, boxes, missing) {
  const all = boxes.map((_, number) => number);
  const near = [];
  for (let i = 0; i < corners.length; i += 3) {
    const face = corners.subarray(i, i + 3);
    const isNear = [...missing].some((number) => meets(positions, face, boxes[number])) ||
        missing.has(nearestBox(boxes, all, positions.subarray(3 * face[0], 3 * face[0] + 3)));
    if (isNear) near.push(...face);
  }
  return Uint32Array.from(near);
}

/** @param {number[]} counts */
const startsOf = (counts) => counts.map((_, i) => counts.slice(0, i).reduce((a, b) => a + b, 0));

/** @param {number[]} counts */
const sumOf = (counts) => counts.reduce((a, b) => a + b, 0);

// Joins meshes to one. The zones of each count on from its number in `firstZones`. `behind`: the corners of the last
// mesh that are drawn, behind the other meshes; null: the last mesh is drawn as the others are.
/** @param {Mesh[]} meshes @param {number[]} firstZones @param {Uint32Array | null} behind @returns {Mesh} */
function joinedMesh(meshes, firstZones, behind) {
  const firsts = startsOf(meshes.map(({zones}) => zones.length));
  const vertices = sumOf(meshes.map(({zones}) => zones.length));
  const before = behind ? meshes.slice(0, -1) : meshes;
  const joined = {
    positions: new Float32Array(3 * vertices), colors: new Uint8Array(4 * vertices),
    shares: new Uint8Array(4 * vertices), zones: new Uint32Array(vertices),
    corners: new Uint32Array(sumOf(before.map(({corners}) => corners.length)) + (behind?.length ?? 0)),
    counts: CELLS_OF_SHADER.map((_, group) => sumOf(before.map((mesh) => mesh.counts[group]))),
    behind: behind?.length ?? 0, offset: meshes.find(({offset}) => offset)?.offset,
  };
  meshes.forEach((mesh, number) => {
    joined.positions.set(mesh.positions, 3 * firsts[number]);
    joined.colors.set(mesh.colors, 4 * firsts[number]);
    joined.shares.set(mesh.shares, 4 * firsts[number]);
    for (let i = 0; i < mesh.zones.length; ++i) joined.zones[firsts[number] + i] = firstZones[number] + mesh.zones[i];
  });
  let at = 0;
  CELLS_OF_SHADER.forEach((_, group) => before.forEach((mesh, number) => {
    const first = startsOf(mesh.counts)[group];
    for (let i = first; i < first + mesh.counts[group]; ++i) joined.corners[at++] = firsts[number] + mesh.corners[i];
  }));
  behind?.forEach((vertex) => {
    joined.corners[at++] = firsts[firsts.length - 1] + vertex;
  });
  return joined;
}

// Joins tables to one, in the order of joinedMesh(), and appends a zone without references.
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

  // Describes all chunks as one mesh file, whose name lists their files.
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

  // Returns the mesh of the chunks that were read. Behind them it has the faces of the coarse mesh that lie where
  // chunks are missing. `coarse`: null where there is no such mesh.
  /** @param {Mesh | null} coarse @returns {Mesh} */
  joined(coarse) {
    const there = this.there.filter((chunk) => chunk !== null);
    const meshes = there.map(({mesh}) => mesh);
    const firstZones = startsOf(there.map(({zones}) => zones));
    const missing = new Set(this.missing());
    if (!coarse || missing.size === 0) return joinedMesh(meshes, firstZones, null);
    // All coarse faces are in the zone without references.
    meshes.push({...coarse, zones: new Uint32Array(coarse.zones.length)});
    firstZones.push(sumOf(there.map(({zones}) => zones)));
    return joinedMesh(meshes, firstZones, cornersNear(coarse, this.boxes, missing));
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

  // Returns the joined tables of the chunks that were read.
  /** @param {Scene} scene */
  async tables(scene) {
    await Promise.all(this.there.map(async (chunk, number) => {
      if (!chunk || chunk.tables) return;
      chunk.tables = await this.sources[number].tables(scene);
      await this.sources[number].release();
    }));
    return joinedTables(this.there.flatMap((chunk) => chunk?.tables ? [chunk.tables] : []));
  }

  // Frees what was read, once no chunk is missing.
  async release() {
    if (this.missing().length === 0) this.there.fill(null);
  }
}
