// SPDX-License-Identifier: GPL-3.0-or-later
// A surface's arrays as the renderer takes them, from its glTF file. blend/tables/zone_mesh.cpp makes the same of a
// model in memory.
import {TextError} from '../texts/texts.js';
/** @import {Gltf} from './gltf.js' */
/** @import {GltfPrimitive, Mesh, Scene, SurfaceProperties, Tables, Vector} from '../types.d.ts' */

const BYTE = 5121;
const SHORT = 5123;
const WHOLE = 5125;
const FLOAT = 5126;
const NONE = 0xFFFFFFFF;
const CELLS_PER_ZONE = 4;                 // kCellsPerZone
export const CELLS_OF_SHADER = [1, 2, 4];  // kCellsOfShader of blend/tables/zone_mesh.h
const FIRST_CELL_BIT = 28;
const NO_ORIGIN = [0, 0, 0];
export const LUMIGRAPH = 'LUMATLAS_lumigraph';

/** @type {Uint8Array | null} */
let srgbTable = null;

// For each value of linear light in 16 bits, sRGB in 8.
function srgbOfLinear() {
  if (srgbTable) return srgbTable;
  srgbTable = new Uint8Array(65536);
  for (let i = 0; i < srgbTable.length; ++i) {
    const linear = i / 65535;
    srgbTable[i] = Math.round(255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055));
  }
  return srgbTable;
}

// Returns what a surface's file says of itself.
/** @param {Gltf} gltf @returns {SurfaceProperties} */
export function propertiesOf(gltf) {
  const properties = gltf.json.extensions?.[LUMIGRAPH];
  if (!properties) throw new TextError('noExtension', {where: gltf.name, extension: LUMIGRAPH});
  return properties;
}

/** @param {Gltf} gltf @param {number} mesh */
function primitiveOf(gltf, mesh) {
  const primitive = gltf.json.meshes?.[mesh]?.primitives[0];
  if (!primitive) throw new Error(`${gltf.name} has no mesh ${mesh}`);
  return primitive;
}

// The meshes of a surface: the scene's, and the far sphere's.
/** @param {Gltf} gltf @param {SurfaceProperties | null} properties */
export function primitivesOf(gltf, properties) {
  return [0, ...properties?.far ? [properties.far.mesh] : []].map((mesh) => primitiveOf(gltf, mesh));
}

/** @param {GltfPrimitive} primitive */
export const colorOf = ({attributes}) => attributes._COLOR ?? attributes.COLOR_0;

// The accessors of a surface's mesh.
/** @param {GltfPrimitive[]} primitives @param {SurfaceProperties | null} properties */
export function meshAccessors(primitives, properties) {
  const ofAll = primitives.flatMap(({attributes, indices}) => [
    attributes.POSITION, attributes._COLOR ?? attributes.COLOR_0, indices,
    ...[attributes._CELL, attributes._ZONE, attributes._SHARES].filter((number) => number !== undefined),
  ]);
  const ofWhole = [properties?.zoneCells, properties?.vertexCopies].filter((number) => number !== undefined);
  return [...ofAll, ...ofWhole];
}

// The accessors of a surface's tables, with those of its mesh that are in the same buffer where it has several.
/** @param {SurfaceProperties} properties */
export function tableAccessors(properties) {
  const {cellSeen, referenceOffsets, references, cellDeviation, resident, vertexCopies, zoneCells} = properties;
  return [cellSeen, referenceOffsets, references, cellDeviation, resident, vertexCopies, zoneCells]
      .filter((number) => number !== undefined);
}

// The cell of each zone, and the cells that its faces fade between. Null: a zone is a cell.
/** @param {Gltf} gltf @param {SurfaceProperties | null} properties */
function zonesOf(gltf, properties) {
  if (properties?.zoneCells === undefined) return null;
  const values = gltf.values(properties.zoneCells, WHOLE, 'SCALAR');
  const count = values.length / (1 + CELLS_PER_ZONE);
  if (!Number.isInteger(count)) throw new Error(`${gltf.name}: its zones are not whole`);
  const columns = Array.from({length: 1 + CELLS_PER_ZONE}, (_, i) => values.subarray(i * count, (i + 1) * count));
  return {count, cell: columns[0], cells: columns.slice(1)};
}

/** @typedef {NonNullable<ReturnType<typeof zonesOf>>} Zones */

// The first shader that takes as many cells as a zone has.
/** @param {Zones | null} zones @param {number} zone */
function shaderOf(zones, zone) {
  let cells = 1;
  while (zones && cells < CELLS_PER_ZONE && zones.cells[cells][zone] !== NONE) ++cells;
  return CELLS_OF_SHADER.findIndex((most) => most >= cells);
}

// Colours of vertices, four bytes each.
/** @param {Gltf} gltf @param {GltfPrimitive[]} primitives */
export function colorsOf(gltf, primitives) {
  const table = srgbOfLinear();
  const linear = primitives.map((primitive) => gltf.values(colorOf(primitive), SHORT, 'VEC4'));
  const colors = new Uint8Array(linear.reduce((sum, values) => sum + values.length, 0));
  let at = 0;
  for (const values of linear) {
    for (let i = 0; i < values.length; ++i) colors[at + i] = table[values[i]];
    at += values.length;
  }
  return colors;
}

// Returns the vertex that stands for each: its original for a copy that differs from it in nothing that is drawn.
/**
 * @param {Gltf} gltf
 * @param {SurfaceProperties | null} properties
 * @param {Uint32Array} zones
 * @param {number} vertices
 */
function originals(gltf, properties, zones, vertices) {
  const stands = new Uint32Array(zones.length);
  for (let i = 0; i < stands.length; ++i) stands[i] = i;
  if (properties?.vertexCopies === undefined) return stands;
  const copies = gltf.values(properties.vertexCopies, WHOLE, 'SCALAR');
  const first = vertices - copies.length;
  if (first < 0 || copies.some((vertex) => vertex >= first)) {
    throw new Error(`${gltf.name}: a vertex is a copy of none`);
  }
  const newest = new Uint32Array(first).fill(NONE);
  const older = new Uint32Array(copies.length);
  for (let i = 0; i < copies.length; ++i) {
    const [vertex, zone] = [copies[i], zones[first + i]];
    let found = newest[vertex];
    while (found !== NONE && zones[first + found] !== zone) found = older[found];
    if (zones[vertex] === zone) {
      stands[first + i] = vertex;
    } else if (found !== NONE) {
      stands[first + i] = first + found;
    } else {
      older[i] = newest[vertex];
      newest[vertex] = i;
    }
  }
  return stands;
}

// Leaves out the vertices that others stand for.
/** @param {Mesh} mesh @param {Uint32Array} stands @returns {Mesh} */
function compacted(mesh, stands) {
  const number = new Uint32Array(stands.length);
  let count = 0;
  for (let i = 0; i < stands.length; ++i) {
    const vertex = stands[i];
    if (vertex !== i) {
      number[i] = number[vertex];
      continue;
    }
    mesh.positions.copyWithin(3 * count, 3 * i, 3 * i + 3);
    mesh.colors.copyWithin(4 * count, 4 * i, 4 * i + 4);
    mesh.shares.copyWithin(4 * count, 4 * i, 4 * i + 4);
    mesh.zones[count] = mesh.zones[i];
    number[i] = count++;
  }
  if (count === stands.length) return mesh;
  const corners = mesh.corners.map((vertex) => number[vertex]);
  return {
    positions: mesh.positions.slice(0, 3 * count), colors: mesh.colors.slice(0, 4 * count),
    shares: mesh.shares.slice(0, 4 * count), zones: mesh.zones.slice(0, count), corners, counts: mesh.counts, behind: 0,
  };
}

// Appends the arrays of one mesh to those of all, from vertex `first` on.
/**
 * @param {Gltf} gltf
 * @param {GltfPrimitive} primitive
 * @param {Mesh} all
 * @param {number} first
 * @param {Vector} origin
 */
function take(gltf, primitive, all, first, origin) {
  const {attributes} = primitive;
  const positions = gltf.values(attributes.POSITION, FLOAT, 'VEC3');
  const vertices = positions.length / 3;
  for (let i = 0; i < positions.length; ++i) all.positions[3 * first + i] = positions[i] + origin[i % 3];
  const zone = attributes._ZONE ?? attributes._CELL;
  if (zone !== undefined) all.zones.set(gltf.values(zone, FLOAT, 'SCALAR').subarray(0, vertices), first);
  if (attributes._SHARES !== undefined) {
    all.shares.set(gltf.values(attributes._SHARES, BYTE, 'VEC4').subarray(0, 4 * vertices), 4 * first);
  } else {
    for (let i = first; i < first + vertices; ++i) all.shares[4 * i] = 255;
  }
  return vertices;
}

// The corners of all faces, those that fewer cells share first.
/**
 * @param {Gltf} gltf
 * @param {GltfPrimitive[]} primitives
 * @param {number[]} firsts
 * @param {Mesh} mesh
 * @param {Zones | null} zones
 */
function takeCorners(gltf, primitives, firsts, mesh, zones) {
  const ofMeshes = primitives.map(({indices}) => gltf.values(indices, WHOLE, 'SCALAR'));
  const ends = [...firsts.slice(1), mesh.zones.length];
  const shaders = zones && Uint8Array.from({length: zones.count}, (_, zone) => shaderOf(zones, zone));
  const shader = (/** @type {number} */ vertex) => shaders ? shaders[mesh.zones[vertex]] : 0;
  const counts = CELLS_OF_SHADER.map(() => 0);
  ofMeshes.forEach((corners, number) => {
    for (let i = 0; i < corners.length; i += 3) {
      for (let corner = i; corner < i + 3; ++corner) {
        if (!(corners[corner] < ends[number] - firsts[number])) {
          throw new Error(`${gltf.name}: a face has no such vertex`);
        }
      }
      counts[shader(firsts[number] + corners[i])] += 3;
    }
  });
  const next = counts.map((_, i) => counts.slice(0, i).reduce((a, b) => a + b, 0));
  mesh.corners = new Uint32Array(counts.reduce((a, b) => a + b));
  mesh.counts = counts;
  ofMeshes.forEach((corners, number) => {
    const first = firsts[number];
    for (let i = 0; i < corners.length; i += 3) {
      const group = shader(first + corners[i]);
      for (let corner = 0; corner < 3; ++corner) mesh.corners[next[group]++] = first + corners[i + corner];
    }
  });
}

// A surface's mesh. `properties`: null for a coarse one, which has vertex colours alone.
/**
 * @param {Gltf} gltf
 * @param {GltfPrimitive[]} primitives
 * @param {SurfaceProperties | null} properties
 * @returns {Mesh}
 */
export function meshOf(gltf, primitives, properties) {
  const counts = primitives.map(({attributes}) => gltf.accessor(attributes.POSITION).count);
  const firsts = counts.map((_, i) => counts.slice(0, i).reduce((a, b) => a + b, 0));
  const vertices = counts.reduce((a, b) => a + b);
  const colors = colorsOf(gltf, primitives);
  if (colors.length !== 4 * vertices) throw new Error(`${gltf.name}: its vertices and colours are not as many`);
  /** @type {Mesh} */
  const mesh = {
    positions: new Float32Array(3 * vertices), colors, shares: new Uint8Array(4 * vertices),
    zones: new Uint32Array(vertices), corners: new Uint32Array(0), counts: [], behind: 0,
  };
  primitives.forEach((primitive, number) => {
    // The far sphere's positions are the model's.
    take(gltf, primitive, mesh, firsts[number], number === 0 ? properties?.origin ?? NO_ORIGIN : NO_ORIGIN);
  });
  const zones = zonesOf(gltf, properties);
  if (zones && mesh.zones.some((zone) => zone >= zones.count)) throw new Error(`${gltf.name}: a vertex is in no zone`);
  takeCorners(gltf, primitives, firsts, mesh, zones);
  return compacted(mesh, originals(gltf, properties, mesh.zones, counts[0]));
}

// Appends the references of a zone of several cells; a view that several of them refer to is listed once.
/** @param {number[]} cells @param {Uint32Array} offsets @param {Uint32Array} references @param {number[]} merged */
function mergeReferences(cells, offsets, references, merged) {
  /** @type {Map<number, number>} */
  const entries = new Map();
  cells.forEach((cell, i) => {
    for (let at = offsets[cell]; at < offsets[cell + 1]; ++at) {
      const view = references[at];
      entries.set(view, (entries.get(view) ?? view) | 1 << (FIRST_CELL_BIT + i));
    }
  });
  for (const entry of entries.values()) merged.push(entry >>> 0);
}

// Refuses numbers that lead nowhere.
/**
 * @param {Gltf} gltf
 * @param {Uint32Array} offsets
 * @param {Uint32Array} references
 * @param {number} cells
 * @param {number} views
 */
function checkReferences(gltf, offsets, references, cells, views) {
  let good = offsets.length === cells + 1 && offsets[0] === 0 && offsets[cells] === references.length;
  for (let cell = 0; good && cell < cells; ++cell) good = offsets[cell] <= offsets[cell + 1];
  if (!good) throw new Error(`${gltf.name}: its references do not belong to its cells`);
  if (references.some((view) => view >= views)) throw new Error(`${gltf.name}: a reference is to no view`);
}

// The tables that shaders/tables.glsl reads.
/** @param {Gltf} gltf @param {SurfaceProperties} properties @param {Scene} scene @returns {Tables} */
export function tablesOf(gltf, properties, scene) {
  const seen = gltf.values(properties.cellSeen, BYTE, 'SCALAR');
  const offsets = /** @type {Uint32Array} */ (gltf.values(properties.referenceOffsets, WHOLE, 'SCALAR'));
  const views = /** @type {Uint32Array} */ (properties.references === undefined ? new Uint32Array() :
    gltf.values(properties.references, WHOLE, 'SCALAR'));
  const deviations = properties.cellDeviation === undefined ? null :
      gltf.values(properties.cellDeviation, FLOAT, 'SCALAR');
  checkReferences(gltf, offsets, views, seen.length + (properties.guestCells ?? 0), scene.views.length);
  const cells = new Uint32Array(3 * seen.length);
  for (let cell = 0; cell < seen.length; ++cell) {
    cells.set([offsets[cell], offsets[cell + 1], seen[cell] ? 1 : 0], 3 * cell);
  }
  /** @type {number[]} */
  const merged = [];
  const ranges = rangesOfZones(gltf, properties, {offsets, views, merged, cells: seen.length});
  const zones = new Uint32Array(4 * ranges.length);
  const real = new Float32Array(1);
  const bits = new Uint32Array(real.buffer);
  ranges.forEach(([from, to, cell], zone) => {
    real[0] = deviations?.[cell] ?? 0;
    zones.set([from, to, cell, bits[0] >>> 16], 4 * zone);
  });
  const references = new Uint32Array(views.length + merged.length);
  references.set(views.map((view) => view | 1 << FIRST_CELL_BIT));
  references.set(merged, views.length);
  return {zones, cells, references, resident: residentTiles(gltf, properties, scene)};
}

// For each zone where its references begin and end, and its cell. What zones of several cells refer to is appended.
/**
 * @param {Gltf} gltf
 * @param {SurfaceProperties} properties
 * @param {{offsets: Uint32Array, views: Uint32Array, merged: number[], cells: number}} tables
 * @returns {number[][]}
 */
function rangesOfZones(gltf, properties, {offsets, views, merged, cells}) {
  const zones = zonesOf(gltf, properties);
  if (!zones) return Array.from({length: cells}, (_, cell) => [offsets[cell], offsets[cell + 1], cell]);
  /** @type {Map<string, number[]>} */
  const known = new Map();
  return Array.from({length: zones.count}, (_, zone) => {
    const of = zones.cells.map((column) => column[zone]).filter((cell) => cell !== NONE);
    if (of.length === 0 || !(zones.cell[zone] < cells) || of.some((cell) => !(cell < offsets.length - 1))) {
      throw new Error(`${gltf.name}: a zone has no such cell`);
    }
    const key = of.join();
    let range = of.length === 1 ? [offsets[of[0]], offsets[of[0] + 1]] : known.get(key);
    if (!range) {
      const first = views.length + merged.length;
      mergeReferences(of, offsets, views, merged);
      range = [first, views.length + merged.length];
      known.set(key, range);
    }
    return [...range, zones.cell[zone]];
  });
}

// For each tile of the views that are there 1 or 0.
/** @param {Gltf} gltf @param {SurfaceProperties} properties @param {Scene} scene */
export function residentTiles(gltf, properties, {views, tile}) {
  const tiles = views.reduce((sum, view) => view ?
      sum + Math.ceil(view.width / tile) * Math.ceil(view.height / tile) : sum, 0);
  if (properties.resident === undefined) return new Uint32Array(tiles).fill(1);
  const resident = gltf.values(properties.resident, BYTE, 'SCALAR');
  if (resident.length !== tiles) throw new Error(`${gltf.name}: its tiles are not those of the views`);
  return Uint32Array.from(resident, (there) => there ? 1 : 0);
}
