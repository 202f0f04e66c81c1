// SPDX-License-Identifier: GPL-3.0-or-later
// A model as it lies beside the page: a tileset, or one .glb (atlas/README.md). What it says of itself is read at once,
// its surface and tables when they are asked for.
import {Chunks} from './chunks.js';
import {Gltf} from './gltf.js';
import {LUMIGRAPH, colorOf, colorsOf, meshAccessors, meshOf} from './surface.js';
import {primitivesOf, propertiesOf, residentTiles, tableAccessors, tablesOf} from './surface.js';
import {TextError} from '../texts/texts.js';
/** @import {SiteFiles} from './site_files.js' */
/**
 * @import {
 *   Mesh, MeshFile, ModelProperties, Scene, Shaders, Tables, Tile, Tileset, View, ViewLists, ViewProperties,
 * } from '../types.d.ts'
 */

const VERSION = 5;
const TILE = 64;             // side of the tiles of a model without
const GUTTER = 4;            // kWholeViews of atlas/tiles/tiles.h
const NEAR_SHARE = 1e-8;     // the renderer's value, see blend/renderer.cpp
const FARTHEST = 3.4028234663852886e38;
export const MOST_SIDE = 2048;  // of a photograph over the network, pixels

/** @param {Scene} scene */
export const viewsOf = ({views}) => views.filter((view) => view !== null);

// Levels of a photograph on the GPU, as levels_of() of atlas/tiles/tiles.h has them.
/** @param {ModelProperties} properties */
function levelsOf(properties) {
  const ofGutter = levelsOfGutter(properties);
  return properties.texels === 'bc7' ? Math.max(ofGutter, 2) - 1 : ofGutter;
}

/** @param {ModelProperties} properties */
const levelsOfGutter = ({tiles}) => 1 + Math.log2(tiles?.gutter ?? GUTTER);

/** @param {ModelProperties | undefined} properties @param {string} where */
function checked(properties, where) {
  if (!properties) throw new TextError('noExtension', {where, extension: LUMIGRAPH});
  const {version} = properties;
  if (version === VERSION) return properties;
  const values = {where, version, extension: LUMIGRAPH, read: VERSION};
  throw new TextError(version < VERSION ? 'olderVersion' : 'otherVersion', values);
}

/** @param {ViewProperties} view @param {(number: number) => string} image @returns {View} */
function viewOf(view, image) {
  const [fx, fy] = view.focalLength;
  const [cx, cy] = view.principalPoint;
  const {name, width, height, rotation, translation, gain, depth = 0} = view;
  return {
    name, width, height, fx, fy, cx, cy, rotation, translation, gain, depth, photograph: image(view.image),
    mask: view.mask === undefined ? null : image(view.mask),
    thumbnail: image(view.thumbnail ?? view.image),
  };
}

// One over the median of the views' depths; 0 where no view sees a surface.
/** @param {(View | null)[]} views */
function inverseDepth(views) {
  const depths = views.flatMap((view) => view && view.depth > 0 ? [view.depth] : []).sort((a, b) => a - b);
  return depths.length > 0 ? 1 / depths[depths.length >> 1] : 0;
}

// Returns the views that a tileset lists; where it names a file of them, the first one alone, in its place.
/** @param {ModelProperties} properties @param {(number: number) => string} image @returns {(View | null)[]} */
function listedViews({views = [], firstView = 0, start}, image) {
  if (!start) return views.map((view) => view && viewOf(view, image));
  return [...Array(firstView).fill(null), viewOf(start, image)];
}

/**
 * @param {ModelProperties} properties
 * @param {Shaders} shaders
 * @param {{image: (number: number) => string, diagonal: number, mesh: MeshFile, coarse: MeshFile | null}} parts
 * @returns {Scene}
 */
function sceneOf(properties, shaders, {image, diagonal, mesh, coarse}) {
  const views = listedViews(properties, image);
  const levels = levelsOf(properties);
  return {
    version: null, blend: shaders.blend, photographed: shaders.photographed, mesh, coarse,
    tile: properties.tiles?.size ?? TILE, levels, cubic_levels: levelsOfGutter(properties) - 1,
    near_depth: NEAR_SHARE * diagonal, depth_before_far: properties.depthBeforeFar ?? FARTHEST,
    median_deviation: properties.medianDeviation ?? 0,
    inverse_depth: inverseDepth(views), up: properties.up ?? [0, 1, 0], first_view: properties.firstView ?? 0,
    poster: properties.poster === undefined ? null : image(properties.poster),
    view_file: properties.viewFile?.uri ?? null, views,
  };
}

/** @param {Tile} tile */
function tileContent({content}) {
  if (!content) throw new Error('a tile has no content');
  return content;
}

// Returns the tiles without children, which are chunks, and those between the root and them that have content, a parent
// before its children, with the numbers of the chunks that it stands for.
/** @param {Tile} root */
function tilesBelow(root) {
  /** @type {Tile[]} */
  const chunks = [];
  /** @type {{tile: Tile, first: number, end: number}[]} */
  const between = [];
  const add = (/** @type {Tile} */ tile) => {
    if (!tile.children?.length) {
      chunks.push(tile);
      return;
    }
    const range = {tile, first: chunks.length, end: 0};
    if (tile !== root && tile.content) between.push(range);
    tile.children.forEach(add);
    range.end = chunks.length;
  };
  add(root);
  return {chunks, between};
}

/** @param {SiteFiles} files @param {ReturnType<typeof tilesBelow>} tiles @returns {Promise<MeshFile>} */
async function surfaceOf(files, {chunks, between}) {
  const sourceOf = (/** @type {Tile} */ tile) => new SurfaceSource(files, tileContent(tile).uri);
  const sources = chunks.map(sourceOf);
  if (chunks.length === 1) return sources[0].described();
  const extras = chunks.map((tile) => tileContent(tile).extras);
  const boxes = extras.map((extra) => extra?.box ?? [0, 0, 0, 0, 0, 0]);
  const bytes = extras.map((extra) => extra?.byteLength ?? 0);
  const standIns = between.map(({tile, first, end}) => ({source: sourceOf(tile), first, end}));
  return new Chunks(sources, boxes, bytes, standIns).described();
}

/** @param {SiteFiles} files @param {{uri: string, byteLength: number}[]} listed */
function noteSizes(files, listed) {
  for (const {uri, byteLength} of listed) files.sizes[uri] = byteLength;
}

// Returns the names of images by their numbers.
/** @param {string} file @param {{uri: string}[]} images */
const namesOf = (file, images) => (/** @type {number} */ number) => {
  const image = images[number];
  if (!image) throw new Error(`${file} has no image ${number}`);
  return image.uri;
};

/** @param {SiteFiles} files @param {string} name @param {Shaders} shaders @param {boolean} anew */
async function tilesetScene(files, name, shaders, anew) {
  /** @type {Tileset} */
  const tileset = await files.json(name, anew);
  const properties = checked(tileset.extensions?.[LUMIGRAPH], name);
  const {root} = tileset;
  const isWhole = !root.children?.length;
  const tiles = tilesBelow(root);
  for (const {content} of [root, ...tiles.chunks, ...tiles.between.map(({tile}) => tile)]) {
    if (content?.extras) files.sizes[content.uri] = content.extras.byteLength;
  }
  noteSizes(files, [...properties.images ?? [], ...properties.viewFile ? [properties.viewFile] : []]);
  const {box} = root.boundingVolume;
  return sceneOf(properties, shaders, {
    image: namesOf(name, properties.images ?? []),
    diagonal: 2 * Math.hypot(box[3], box[7], box[11]),
    mesh: await surfaceOf(files, tiles),
    coarse: isWhole || !root.content ? null : await new SurfaceSource(files, root.content.uri).described(),
  });
}

/** @param {SiteFiles} files @param {string} name @param {Shaders} shaders @param {boolean} anew */
async function glbScene(files, name, shaders, anew) {
  const gltf = await Gltf.readInParts(files, name, anew);
  const properties = /** @type {ModelProperties} */ (/** @type {unknown} */ (propertiesOf(gltf)));
  checked(properties, name);
  const {POSITION} = primitivesOf(gltf, null)[0].attributes;
  const {min = [0, 0, 0], max = [0, 0, 0]} = gltf.accessor(POSITION);
  const coarse = propertiesOf(gltf).coarse;
  return sceneOf(properties, shaders, {
    image: (number) => gltf.imageName(number),
    diagonal: Math.hypot(...min.map((low, axis) => max[axis] - low)),
    mesh: await new SurfaceSource(files, name, gltf).described(),
    coarse: coarse === undefined ? null : await new SurfaceSource(files, name, gltf, coarse).described(),
  });
}

// `name`: of a tileset or a .glb. `anew`: as the server has it now, whatever the browser has kept.
/** @param {SiteFiles} files @param {string} name @param {Shaders} shaders @returns {Promise<Scene>} */
export async function loadScene(files, name, shaders, anew = false) {
  return name.endsWith('.glb') ? glbScene(files, name, shaders, anew) : tilesetScene(files, name, shaders, anew);
}

// Returns the scene with all of its views, for which it reads their file if there is one.
/** @param {SiteFiles} files @param {Scene} scene @returns {Promise<Scene>} */
export async function withAllViews(files, scene) {
  const name = scene.view_file;
  if (name === null) return scene;
  /** @type {ViewLists} */
  const lists = await files.json(name);
  noteSizes(files, lists.images);
  const views = lists.views.map((view) => viewOf(view, namesOf(name, lists.images)));
  if (!views[scene.first_view]) throw new Error(`${name} lists ${views.length} views, too few`);
  return {...scene, view_file: null, views, inverse_depth: inverseDepth(views)};
}

// Tells texts apart.
/** @param {string} text */
function digest(text) {
  let sum = 0;
  for (let i = 0; i < text.length; ++i) sum = Math.imul(sum, 31) + text.charCodeAt(i) | 0;
  return sum;
}

// The source of a surface. Its file is read once for its mesh and its tables.
class SurfaceSource {
  // `gltf`: the file, if it is open already. `coarse`: the number of a coarse mesh in it.
  /** @param {SiteFiles} files @param {string} uri @param {Gltf | null} gltf @param {number | null} coarse */
  constructor(files, uri, gltf = null, coarse = null) {
    this.files = files;
    this.uri = uri;
    this.coarse = coarse;
    this.kept = gltf !== null;  // of a file that is read in parts, or whose buffers are files
    /** @type {Promise<Gltf> | null} */
    this.opened = gltf && Promise.resolve(gltf);
  }

  // The names of the files that hold mesh, colours and tables. A .gltf is small, and names its buffers' files; its
  // origin says where the mesh is.
  /** @returns {Promise<MeshFile>} */
  async described() {
    const version = this.kept ? ` ${digest(JSON.stringify((await this.open()).json))}` : '';
    const name = this.uri + version + (this.coarse === null ? '' : ', coarse');
    if (!this.uri.endsWith('.gltf')) return {file: name, colors: name, tables: name, source: this, chunks: null};
    this.kept = true;
    const gltf = await this.open();
    const [primitive] = primitivesOf(gltf, null);
    const {origin = []} = propertiesOf(gltf);
    const mesh = gltf.bufferName(primitive.attributes.POSITION);
    return {
      file: [mesh, ...origin].join(' '), colors: gltf.bufferName(colorOf(primitive)),
      tables: gltf.bufferName(propertiesOf(gltf).cellSeen), source: this, chunks: null,
    };
  }

  async open() {
    this.opened ??= Gltf.read(this.files, this.uri);
    try {
      return await this.opened;
    } catch (error) {
      this.opened = null;
      throw error;
    }
  }

  // Lets go of what was read.
  async release() {
    const gltf = await this.opened;
    gltf?.release();
    if (!this.kept) this.opened = null;
  }

  async mesh() {
    const gltf = await this.open();
    const properties = this.coarse === null && gltf.json.extensions?.[LUMIGRAPH] ? propertiesOf(gltf) : null;
    const primitives = this.coarse === null ? primitivesOf(gltf, properties) :
      [/** @type {NonNullable<typeof gltf.json.meshes>} */ (gltf.json.meshes)[this.coarse].primitives[0]];
    await gltf.load(meshAccessors(primitives, properties));
    const mesh = meshOf(gltf, primitives, properties);
    return {...mesh, offset: properties?.offset, hasFar: primitives.length > 1};
  }

  async colors() {
    const gltf = await this.open();
    const primitives = primitivesOf(gltf, propertiesOf(gltf));
    await gltf.load(primitives.map(colorOf));
    return colorsOf(gltf, primitives);
  }

  // Returns for each tile of the scene 1 or 0: whether it is among the photographs. It reads no more of the file than
  // what says so.
  /** @param {Scene} scene */
  async residentTiles(scene) {
    const isOpen = this.opened !== null || !this.uri.endsWith('.glb');
    const gltf = isOpen ? await this.open() : await Gltf.readInParts(this.files, this.uri, false);
    const properties = propertiesOf(gltf);
    if (properties.resident !== undefined) await gltf.load([properties.resident]);
    return residentTiles(gltf, properties, scene);
  }

  /** @param {Scene} scene */
  async tables(scene) {
    const gltf = await this.open();
    const properties = propertiesOf(gltf);
    await gltf.load(tableAccessors(properties));
    return tablesOf(gltf, properties, scene);
  }
}

// The page's own, whatever becomes of the scene. index.html says under which name.
/** @param {SiteFiles} files @returns {Promise<Shaders>} */
export const loadShaders = (files) => files.json(document.documentElement.dataset.shaders ?? 'shaders.json');

// Arrays as the renderer takes them. `mesh`: the scene's own, or its coarse one.
/** @param {MeshFile} mesh @returns {Promise<Mesh>} */
export async function loadMesh({source}) {
  const mesh = await source.mesh();
  if (source.coarse !== null) await source.release();
  return mesh;
}

// Four bytes for each of the mesh's vertices, of a surface whose colours are in a file of their own.
/** @param {Scene} scene */
export const loadColors = ({mesh}) => mesh.source.colors();

// Returns for each tile of the scene 1 or 0: whether it is among the photographs.
/** @param {Scene} scene */
export const loadResidentTiles = (scene) => scene.mesh.source.residentTiles(scene);

/** @param {Scene} scene @returns {Promise<Tables>} */
export async function loadTables(scene) {
  const tables = await scene.mesh.source.tables(scene);
  await scene.mesh.source.release();
  return tables;
}

/** @type {ImageBitmapOptions} */
const AS_IT_IS = {premultiplyAlpha: 'none', colorSpaceConversion: 'none', imageOrientation: 'none'};

// Pixels of an image as they are in the file: no colour management, not turned. One that is too large for the GPU is
// scaled down.
/** @param {SiteFiles} files @param {string} name @param {View} view @param {ResizeQuality} quality */
function loadImage(files, name, view, quality) {
  const scale = Math.min(1, MOST_SIDE / Math.max(view.width, view.height));
  const size = scale === 1 ? {} : {
    resizeWidth: Math.ceil(view.width * scale), resizeHeight: Math.ceil(view.height * scale), resizeQuality: quality,
  };
  return files.read(name, async (blob) => {
    const image = await createImageBitmap(blob, {...AS_IT_IS, ...size});
    const isWhole = scale < 1 || (image.width === view.width && image.height === view.height);
    if (!isWhole) throw new Error('it has another size than its view');
    return image;
  });
}

// A view's validity and rims (atlas/README.md); null: all of it is valid.
/** @param {SiteFiles} files @param {View} view */
export async function loadMask(files, view) {
  return view.mask === null ? null : loadImage(files, view.mask, view, 'pixelated');
}

/** @param {SiteFiles} files @param {View} view */
export const loadPhotograph = (files, view) => loadImage(files, view.photograph, view, 'high');
