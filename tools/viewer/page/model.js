// SPDX-License-Identifier: GPL-3.0-or-later
// A site's scene: what it says of itself at once, its mesh and tables when they are asked for.
import {inflated, unpack} from './packed_arrays.js';

export const FORMAT = 2;

export async function loadScene(files) {
  const scene = await files.json('scene.json');
  if (scene.format !== FORMAT) {
    throw new Error(`scene.json has the format ${scene.format}, this page reads ${FORMAT}: export the model again`);
  }
  return scene;
}

// {definitions, sources}; the page's own, whatever becomes of the scene.
export const loadShaders = (files) => files.json('shaders.json');

// Arrays as the renderer takes them. `mesh`: the scene's own, or its coarse one.
export async function loadMesh(files, mesh) {
  const packed = unpack(await inflated(await files.array(mesh.file)), mesh.arrays);
  const positions = new Float32Array(packed.positions.length);
  for (let i = 0; i < positions.length; ++i) {
    positions[i] = mesh.origin[i % 3] + mesh.step * packed.positions[i];
  }
  return {
    positions,
    colors: fourBytes(packed.colors),
    shares: fourBytes(packed.shares),
    zones: packed.zones,
    corners: packed.corners,
    counts: mesh.corner_counts,
  };
}

// Three values an entry as bytes, with a fourth that makes them fit where the GPU reads.
function fourBytes(values) {
  const bytes = new Uint8Array(values.length / 3 * 4);
  for (let i = 0; i < values.length; ++i) bytes[(i / 3 | 0) * 4 + i % 3] = values[i];
  return bytes;
}

// Four bytes for each of the mesh's vertices; null where they are the mesh's own.
export async function loadColors(files, scene) {
  if (!scene.colors) return null;
  return fourBytes(unpack(await inflated(await files.array(scene.colors.file)), scene.colors.arrays).colors);
}

export async function loadTables(files, scene) {
  return unpack(await inflated(await files.array(scene.tables.file)), scene.tables.arrays);
}

// A view's validity, 0 to 255, and whether it is at a rim, for each pixel.
export async function loadMask(files, view) {
  const file = await files.array(view.mask);
  const pixels = Math.ceil(view.width - 1e-9) * Math.ceil(view.height - 1e-9);
  const {validity, rim} = unpack(await inflated(file.subarray(2)), [
    {name: 'validity', components: 1, entries: pixels, coding: 'difference', bytes: file[0]},
    {name: 'rim', components: 1, entries: Math.ceil(pixels / 32), coding: 'plain', bytes: file[1]},
  ]);
  const mask = new Uint8Array(2 * pixels);
  for (let i = 0; i < pixels; ++i) {
    mask[2 * i] = validity[i];
    mask[2 * i + 1] = rim[i >> 5] >>> (i & 31) & 1;
  }
  return mask;
}
