// SPDX-License-Identifier: GPL-3.0-or-later
// Makes fewer faces through the same vertices, for drafts: all vertices in a cube whose faces look the same way become
// one of them, and faces with two corners in one are left out. Rossignac and Borrel, "Multi-resolution 3D
// approximations for rendering complex scenes", 1993.

const CUBE_EDGES = 5;      // a cube's side, in median edges
const MOST_FACES = 8e6;     // whose edges fit a Map
const MOST_SAMPLES = 2000;  // edges that the median is of

// Returns the median length of some of a mesh's edges.
/** @param {Float32Array} positions @param {Uint32Array} corners */
function medianEdge(positions, corners) {
  const step = 3 * Math.max(1, Math.floor(corners.length / 3 / MOST_SAMPLES));
  /** @type {number[]} */
  const lengths = [];
  for (let i = 0; i + 1 < corners.length; i += step) {
    const [a, b] = [3 * corners[i], 3 * corners[i + 1]];
    lengths.push(Math.hypot(...[0, 1, 2].map((axis) => positions[a + axis] - positions[b + axis])));
  }
  return lengths.sort((a, b) => a - b)[Math.floor(lengths.length / 2)] ?? 0;
}

// Returns for each point of three numbers the first one of the same numbers.
/** @param {Float64Array} points @returns {Uint32Array<ArrayBuffer>} */
function firstOfSame(points) {
  const count = points.length / 3;
  const first = new Uint32Array(count);
  const size = 2 ** Math.ceil(Math.log2(2 * count + 1));
  const table = new Int32Array(size).fill(-1);  // by hash, one of each
  for (let point = 0; point < count; ++point) {
    const [x, y, z] = [points[3 * point], points[3 * point + 1], points[3 * point + 2]];
    const isOther = (/** @type {number} */ at) =>
        points[3 * at] !== x || points[3 * at + 1] !== y || points[3 * at + 2] !== z;
    let hash = Math.imul(x, 73856093) ^ Math.imul(y, 19349663) ^ Math.imul(z, 83492791);
    hash = Math.imul(hash ^ (hash >>> 15), 0x85ebca6b);  // the lower bits may all be 0
    let slot = (hash ^ (hash >>> 13)) & (size - 1);
    while (table[slot] >= 0 && isOther(table[slot])) slot = (slot + 1) & (size - 1);
    if (table[slot] < 0) table[slot] = point;
    first[point] = table[slot];
  }
  return first;
}

// Returns for each vertex 1 or 0: whether it is at the mesh's border, where another mesh may go on. `place`: for each
// vertex the first one at the same place.
/** @param {Uint32Array} place @param {Uint32Array} corners */
function atBorder(place, corners) {
  /** @type {Map<number, number>} */
  const faces = new Map();  // of each edge
  const edgeAt = (/** @type {number} */ corner) => {
    const next = corner % 3 === 2 ? corner - 2 : corner + 1;
    const ends = [place[corners[corner]], place[corners[next]]];
    return Math.min(...ends) * place.length + Math.max(...ends);
  };
  for (let i = 0; i < corners.length; ++i) {
    const edge = edgeAt(i);
    faces.set(edge, (faces.get(edge) ?? 0) + 1);
  }
  const border = new Uint8Array(place.length);
  for (const [edge, count] of faces) {
    if (count === 1) border[Math.floor(edge / place.length)] = border[edge % place.length] = 1;
  }
  return place.map((first) => border[first]);
}

// Returns for each place the direction, of six, that its last face looks in, so that the two sides of a thin wall stay
// apart. `place` as in atBorder().
/** @param {Float32Array} positions @param {Uint32Array} place @param {Uint32Array} corners */
function directions(positions, place, corners) {
  const result = new Uint8Array(place.length);
  for (let i = 0; i < corners.length; i += 3) {
    const [a, b, c] = [3 * corners[i], 3 * corners[i + 1], 3 * corners[i + 2]];
    const [ux, uy, uz] = [0, 1, 2].map((axis) => positions[b + axis] - positions[a + axis]);
    const [vx, vy, vz] = [0, 1, 2].map((axis) => positions[c + axis] - positions[a + axis]);
    const normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    const sizes = normal.map(Math.abs);
    const axis = sizes.indexOf(Math.max(...sizes));
    const direction = 2 * axis + (normal[axis] < 0 ? 1 : 0);
    for (const at of [a, b, c]) result[place[at / 3]] = direction;
  }
  return result;
}

// Returns the corners of fewer faces through the same vertices. Vertices at the border stay. All corners where little
// would be gained, and of a mesh of more faces than MOST_FACES.
/** @param {Float32Array} positions @param {Uint32Array<ArrayBuffer>} corners @returns {Uint32Array<ArrayBuffer>} */
export function clusteredFaces(positions, corners) {
  const side = CUBE_EDGES * medianEdge(positions, corners);
  if (!(side > 0) || corners.length > 3 * MOST_FACES) return corners;
  const bits = new Int32Array(positions.buffer, positions.byteOffset, positions.length);
  const place = firstOfSame(Float64Array.from(bits));
  const border = atBorder(place, corners);
  const facing = directions(positions, place, corners);
  const cubes = Float64Array.from(positions, (value) => Math.floor(value / side));
  // Seven cubes in x for each, one a direction and one for the border, which stands for no other vertex.
  for (let i = 0; i < place.length; ++i) cubes[3 * i] = 7 * cubes[3 * i] + (border[i] ? 6 : facing[place[i]]);
  const standing = firstOfSame(cubes);
  const standingFor = (/** @type {number} */ vertex) => border[vertex] ? vertex : standing[vertex];
  const result = new Uint32Array(corners.length);
  let count = 0;
  for (let i = 0; i < corners.length; i += 3) {
    const [a, b, c] = [corners[i], corners[i + 1], corners[i + 2]].map(standingFor);
    if (a === b || b === c || c === a) continue;
    result.set([a, b, c], count);
    count += 3;
  }
  return 2 * count > corners.length ? corners : result.slice(0, count);
}
