// SPDX-License-Identifier: GPL-3.0-or-later
// A surface in chunks, each a file of its own, and the faces of a coarse mesh that stand in where some are missing.
/** @import {Chunk, ChunkSource, DrawnChunk, Mesh, MeshFile, Scene, StandIn} from '../types.d.ts' */

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

// Returns how far a point is from a box.
/** @param {number[]} box @param {ArrayLike<number>} point */
export const distanceToBox = (box, point) => Math.sqrt(distanceTo(box, point).outside);

// Returns the number of the box that is nearest to a point. Of boxes at the same distance, it takes the one whose
// middle is nearest.
/** @param {number[][]} boxes @param {ArrayLike<number>} point */
function nearestBox(boxes, point) {
  let best = -1;
  let least = {outside: Infinity, middle: Infinity};
  for (let number = 0; number < boxes.length; ++number) {
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

// The faces of a coarse mesh by the chunks in whose place they stand: those whose boxes they meet, and the one whose
// box is nearest to their first vertex.
export class CoarseFaces {
  // `boxes`: of the chunks from the one numbered `firstChunk` on.
  /** @param {Mesh} mesh @param {number[][]} boxes @param {number} firstChunk */
  constructor({positions, corners}, boxes, firstChunk) {
    this.corners = corners;
    /** @type {number[]} */
    const chunks = [];
    this.firsts = new Uint32Array(corners.length / 3 + 1);  // of each face's in `chunks`
    for (let face = 0; 3 * face < corners.length; ++face) {
      const vertices = corners.subarray(3 * face, 3 * face + 3);
      boxes.forEach((box, number) => {
        if (meets(positions, vertices, box)) chunks.push(number);
      });
      if (chunks.length === this.firsts[face]) {
        chunks.push(nearestBox(boxes, positions.subarray(3 * vertices[0], 3 * vertices[0] + 3)));
      }
      this.firsts[face + 1] = chunks.length;
    }
    this.chunks = Uint32Array.from(chunks, (number) => firstChunk + number);
  }

  // Returns the corners of the faces that stand in for chunks.
  /** @param {(chunk: number) => boolean} isMissing */
  standingFor(isMissing) {
    const {corners, firsts, chunks} = this;
    const near = new Uint32Array(corners.length);
    let count = 0;
    for (let face = 0; 3 * face < corners.length; ++face) {
      if (!chunks.subarray(firsts[face], firsts[face + 1]).some(isMissing)) continue;
      near.set(corners.subarray(3 * face, 3 * face + 3), count);
      count += 3;
    }
    return near.slice(0, count);
  }
}

// The chunks of a surface.
export class Chunks {
  // `boxes`: where each of the sources' meshes lies. `bytes`: how many each of their files has; 0: that is not known.
  /** @param {ChunkSource[]} sources @param {number[][]} boxes @param {number[]} bytes @param {StandIn[]} standIns */
  constructor(sources, boxes, bytes, standIns) {
    this.sources = sources;
    this.boxes = boxes;
    this.bytes = bytes;
    this.standIns = standIns;  // coarse meshes of some chunks each, a coarser one before those of its chunks
  }

  // Describes all chunks as one mesh file, whose name lists their files.
  /** @returns {MeshFile} */
  described() {
    const file = this.sources.map(({uri}) => uri).join();
    return {file, colors: file, tables: file, source: this.sources[0], chunks: this};
  }

  // Reads the coarse mesh that stands in for some chunks and lets go of its file.
  /** @param {number} number */
  async loadStandIn(number) {
    const {source} = this.standIns[number];
    const mesh = await source.mesh();
    await source.release();
    return mesh;
  }

  // Reads a chunk and lets go of its file. `drawn`: chunks by the files of their meshes, of which it takes out the one
  // whose mesh is not read again.
  /** @param {number} number @param {Scene} scene @param {Map<string, DrawnChunk>} drawn @returns {Promise<Chunk>} */
  async load(number, scene, drawn) {
    const source = this.sources[number];
    const {file, colors} = await source.described();
    const like = drawn.get(file) ?? null;
    drawn.delete(file);
    const [tables, mesh, newColors] = await Promise.all([
      source.tables(scene), like ? null : source.mesh(), like && like.colors !== colors ? source.colors() : null,
    ]);
    await source.release();
    return {number, uri: source.uri, parts: {mesh: file, colors}, like, mesh, colors: newColors, tables};
  }
}
