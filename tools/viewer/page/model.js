// SPDX-License-Identifier: GPL-3.0-or-later
// A site's scene: what it says of itself at once, its mesh and tables when they are asked for.
import {inflated, unpack} from './packed_arrays.js';
/** @import {SiteFiles} from './site_files.js' */
/** @import {Mesh, MeshFile, Scene, Shaders, Tables, View} from './types.d.ts' */

const FORMAT = 3;

/** @param {Scene} scene */
export const viewsOf = ({views}) => views.filter((view) => view !== null);

// `anew`: as the server has it now, whatever the browser has kept.
/** @param {SiteFiles} files @returns {Promise<Scene>} */
export async function loadScene(files, anew = false) {
  const scene = await files.json('scene.json', anew);
  if (scene.format !== FORMAT) {
    throw new Error(`scene.json has the format ${scene.format}, this page reads ${FORMAT}: export the model again`);
  }
  Object.assign(files.sizes, scene.bytes);
  return scene;
}

// The page's own, whatever becomes of the scene. index.html says under which name.
/** @param {SiteFiles} files @returns {Promise<Shaders>} */
export const loadShaders = (files) => files.json(document.documentElement.dataset.shaders ?? 'shaders.json');

// Arrays as the renderer takes them. `mesh`: the scene's own, or its coarse one.
/** @param {SiteFiles} files @param {MeshFile} mesh @returns {Promise<Mesh>} */
export async function loadMesh(files, mesh) {
  const packed = await files.array(mesh.file, async (bytes) => unpack(await inflated(bytes), mesh.arrays));
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
/** @param {Uint32Array} values */
function fourBytes(values) {
  const bytes = new Uint8Array(values.length / 3 * 4);
  for (let i = 0; i < values.length; ++i) bytes[(i / 3 | 0) * 4 + i % 3] = values[i];
  return bytes;
}

// Four bytes for each of the mesh's vertices; null where they are the mesh's own.
/** @param {SiteFiles} files @param {Scene} scene */
export async function loadColors(files, {colors}) {
  if (!colors) return null;
  const arrays = await files.array(colors.file, async (bytes) => unpack(await inflated(bytes), colors.arrays));
  return fourBytes(arrays.colors);
}

/** @param {SiteFiles} files @param {Scene} scene @returns {Promise<Tables>} */
export async function loadTables(files, {tables}) {
  const {zones, cells, references, resident} =
      await files.array(tables.file, async (bytes) => unpack(await inflated(bytes), tables.arrays));
  return {zones, cells, references, resident};
}

// A view's validity, 0 to 255, and whether it is at a rim, for each pixel.
/** @param {SiteFiles} files @param {View} view */
export function loadMask(files, view) {
  return files.array(view.mask, async (file) => {
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
  });
}

// A view's photograph as it is in the file: no colour management, not turned.
/** @param {SiteFiles} files @param {View} view */
export function loadPhotograph(files, view) {
  return files.read(view.photograph, (blob) => createImageBitmap(
      blob, {premultiplyAlpha: 'none', colorSpaceConversion: 'none', imageOrientation: 'none'}));
}
