// SPDX-License-Identifier: GPL-3.0-or-later
// Types of what the page's modules hand to each other. Only the type checker reads this file; it is no part of a site.

import type {Chunks} from './reading/chunks.js';
import type {EN} from './texts/en.js';
import type {Texts} from './texts/texts.js';

export type Vector = number[];    // x, y, z
export type Rotation = number[];  // nine numbers, row by row: camera from world coordinates
export type Size = [width: number, height: number];

export interface Pose {
  position: Vector;
  rotation: Rotation;
}

// A pinhole camera, as mesh/camera/camera.h has it.
export interface Camera {
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  rotation: Rotation;
  translation: Vector;
}

// What stands where a picture has no surface: colours from above to below, each in [0, 1]. `continues`: the surface's own
// colours go on instead.
export interface Background {
  above: Vector;
  below: Vector;
  continues: boolean;
}

// A stored view; the three names are of files, or of parts of one.
export interface View extends Camera {
  name: string;
  photograph: string;
  mask: string | null;
  thumbnail: string;
  gain: Vector;
  depth: number;
}

// A part of a file.
export interface FilePart {
  from: number;
  length: number;
}

// The part of glTF 2.0 that the page reads.
export interface GltfView {
  buffer: number;
  byteOffset?: number;
  byteLength: number;
  extensions?: {
    EXT_meshopt_compression?: {
      buffer: number;
      byteOffset?: number;
      byteLength: number;
      byteStride: number;
      count: number;
      mode: string;
      filter?: string;
    };
  };
}

export interface GltfPrimitive {
  attributes: Record<string, number>;
  indices: number;
}

export interface GltfJson {
  accessors?: {
    bufferView?: number;
    byteOffset?: number;
    componentType: number;
    count: number;
    type: string;
    min?: number[];
    max?: number[];
  }[];
  bufferViews?: GltfView[];
  buffers?: {uri?: string}[];
  images?: {uri?: string, bufferView?: number}[];
  meshes?: {primitives: GltfPrimitive[]}[];
  extensions?: {LUMATLAS_lumigraph?: SurfaceProperties};
}

// atlas/LUMATLAS_lumigraph.schema.json: the properties of a surface, whose numbers are of accessors.
export interface SurfaceProperties {
  cellSeen: number;
  referenceOffsets: number;
  references?: number;
  cellDeviation?: number;
  resident?: number;
  zoneCells?: number;
  vertexCopies?: number;
  far?: {mesh: number, cells: number};
  coarse?: number;
  origin?: Vector;
  offset?: Vector;
  guestCells?: number;
}

export interface ViewProperties {
  name: string;
  width: number;
  height: number;
  focalLength: [number, number];
  principalPoint: [number, number];
  rotation: Rotation;
  translation: Vector;
  gain: Vector;
  depth?: number;
  image: number;
  mask?: number;
  thumbnail?: number;
}

// The properties of a whole model. A view is null where the slot of a model that changes is free.
export interface ModelProperties {
  version: number;
  texels?: string;
  tiles?: {size: number, gutter: number};
  up?: Vector;
  firstView?: number;
  depthBeforeFar?: number;
  medianDeviation?: number;
  poster?: number;
  images?: {uri: string, byteLength: number}[];
  views?: (ViewProperties | null)[];
  start?: ViewProperties;  // the first view, where the views are listed in a file of their own
  viewFile?: {uri: string, byteLength: number};
}

// The lists of a model's file of views.
export interface ViewLists {
  images: {uri: string, byteLength: number}[];
  views: ViewProperties[];
}

export interface Tile {
  boundingVolume: {box: number[]};
  content?: {uri: string, extras?: {byteLength: number, box?: number[]}};
  children?: Tile[];
}

export interface Tileset {
  root: Tile;
  extensions?: {LUMATLAS_lumigraph?: ModelProperties};
}

// The source of a mesh.
export interface MeshSource {
  coarse: number | null;
  kept: boolean;
  mesh(): Promise<Mesh>;
  colors(): Promise<Uint8Array<ArrayBuffer>>;
  tables(scene: Scene): Promise<Tables>;
  residentTiles(scene: Scene): Promise<Uint32Array<ArrayBuffer>>;
  release(): Promise<void>;
}

// The files that hold a surface's mesh, its colours and its tables, which may be one.
export interface MeshFile {
  file: string;
  colors: string;
  tables: string;
  source: MeshSource;     // of chunks the first
  chunks: Chunks | null;  // of a surface in several files
}

// A file with a chunk.
export interface ChunkSource extends MeshSource {
  uri: string;
  described(): Promise<MeshFile>;
}

// A coarse mesh that stands in for the chunks from `first` to before `end`.
export interface StandIn {
  source: ChunkSource;
  first: number;
  end: number;
}

// The files that the mesh and the colours of a chunk are in.
export interface ChunkParts {
  mesh: string;
  colors: string;
}

// A chunk on the GPU, by the name of its piece.
export interface DrawnChunk extends ChunkParts {
  uri: string;
  box: number[];
}

// The content of a chunk. Of one whose mesh another one has that is drawn, its colours alone, if they are others.
export interface Chunk {
  number: number;
  uri: string;
  parts: ChunkParts;
  mesh: Mesh | null;
  like: DrawnChunk | null;
  colors: Uint8Array<ArrayBuffer> | null;
  tables: Tables;
}

// blend/blend_options.h
export interface BlendSettings {
  views: number;
  lambda: number;
  printed_position: boolean;
  rims: boolean;
  fade_last: boolean;
  consistent: boolean;
  frame_fade: number;
  cubic: boolean;
  soften: boolean;
  soft_edges: boolean;
  outlines: boolean;
  prefilter: boolean;
  nearby_exposure: boolean;
  supersample: number;
  antialias_all: boolean;
  occlusion_tolerance: number;
}

// A model as the page draws it; model.js makes it of the model's files.
export interface Scene {
  version: number | null;  // the version of a model that changes
  blend: BlendSettings;
  mesh: MeshFile;
  coarse: MeshFile | null;
  tile: number;
  levels: number;
  cubic_levels: number;
  near_depth: number;
  depth_before_far: number;
  median_deviation: number;
  inverse_depth: number;
  up: Vector;
  photographed: {cosine: number; enlargement: number; share: number};
  first_view: number;
  poster: string | null;
  view_file: string | null;  // lists the views, of which only the first is known yet
  views: (View | null)[];  // one per view slot
}

// live.json of a model that changes
export interface LiveState {
  version: number;  // 0: no model yet
  last: boolean;
}

export interface Shaders {
  definitions: string;
  sources: Record<string, string>;
  blend: BlendSettings;
  photographed: {cosine: number; enlargement: number; share: number};
}

// A mesh as the renderer takes it.
export interface Mesh {
  positions: Float32Array<ArrayBuffer>;
  colors: Uint8Array<ArrayBuffer>;
  shares: Uint8Array<ArrayBuffer>;
  zones: Uint32Array<ArrayBuffer>;
  corners: Uint32Array<ArrayBuffer>;
  counts: number[];
  behind: number;  // how many of the corners, the last, are drawn a little behind the others
  offset?: Vector;    // of the input's positions from these, of a mesh that says it
  hasFar?: boolean;   // it has the far sphere
}

export interface Tables {
  zones: Uint32Array<ArrayBuffer>;
  cells: Uint32Array<ArrayBuffer>;
  references: Uint32Array<ArrayBuffer>;
  resident: Uint32Array<ArrayBuffer>;
}

// A view over the network: its photograph and mask, decoded.
export interface FetchedView {
  slot: number;
  picture: ImageBitmap;
  mask: ImageBitmap | null;  // null: all of it is valid
}

// A form in which the GPU holds texels of photographs; see photograph_forms.js.
export interface TexelForm {
  name: string;
  internal: number;
  texelBytes: number;
  blocks: boolean;
}

export interface ViewTiles {
  first: number;
  columns: number;
  count: number;
}

// The texture array that photographs are in; see layout.js.
export interface Layout {
  form: TexelForm;
  scale: number;
  tile: number;
  count: number;
  cell: Size;
  columns: number;
  rows: number;
  pages: number;
  size: Size;
  fits: boolean;
  bytes: number;
  slotColumns: number;
  slotRows: number;
  views: (ViewTiles | null)[];
  tiles: number;
}

export interface CellPlace {
  page: number;
  x: number;
  y: number;
}

export type Mode = 'picture' | 'winner' | 'weights' | 'coverage' | 'geometry' | 'colours';
export type Quality = 'auto' | 'sharp' | 'fast';

// Keys of the page's texts; SaidKey also has those of which a count chooses.
export type TextKey = keyof typeof EN;
type CountedKey<Key> = Key extends `${infer Name}.one` ? Name : never;
export type SaidKey = Exclude<TextKey, `${string}.${string}`> | CountedKey<TextKey>;
export type SaidValues = Record<string, string | number | Said>;

// A text before the language is chosen.
export interface Said {
  key: SaidKey;
  values?: SaidValues;
}

// Settings for a bad network; see fetching.js.
export interface NetworkOptions {
  tries?: number;           // tries of each request, at least 1
  pauseMs?: number;         // before the second try; each later pause is twice as long
  stalledMs?: number;       // without a byte, after which a try counts as failed
  laterMs?: number;         // until what is missing is asked for again; each later pause is twice as long
  random?: () => number;    // in [0, 1), spreads the pauses of many visitors
  signal?: AbortSignal;     // ends all requests
}

export interface ViewerOptions {
  base: string;              // address of the folder that the site's files are in
  memory: number;            // MiB that may be used on the GPU
  texels: string;            // see texelForm()
  model?: string;            // the model's file: tileset.json, or a .glb
  live?: string;             // file that says which version of a changing model there is
  network?: NetworkOptions;
  signal?: AbortSignal;      // ends the viewer
  gl?: WebGL2RenderingContext;  // a context to share; otherwise the viewer makes its canvas' own
  shaders?: Shaders;         // otherwise the viewer fetches those of the site
  texts?: Texts;             // the language of messages; otherwise English
}

// A point of the surface. `deviation`: standard deviation of the surface there, scene units; null: it is not known.
export interface SurfacePoint {
  point: Vector;
  deviation: number | null;
}

// The unit in which lengths are shown, and how many of them a scene unit is.
export interface LengthUnit {
  name: string;
  length: number;
}

// A camera of the owner's file: `turned` is a quaternion x, y, z, w, `fov` the angle from top to bottom, degrees.
export interface SavedView {
  position: Vector;
  turned: number[];
  fov: number;
}

// A box outside of which the surface is hidden; its axes are the rows of the rotation that `turned` is.
export interface CropBox {
  center: Vector;
  size: Vector;
  turned: number[];
}

export interface HiddenBall {
  center: Vector;
  radius: number;
}

export interface Annotation {
  point: Vector;
  title: string;
  text: string;
  view: SavedView | null;
}

// The owner's file beside a model; positions are the model's, null and empty: nothing is said.
export interface PageFile {
  title: string;
  description: string;
  view: SavedView | null;
  up: Vector | null;
  unit: LengthUnit | null;
  crop: CropBox | null;
  hidden: HiddenBall[];
  annotations: Annotation[];
}

// A camera's place on a path: the quaternion x, y, z, w gives camera from world, `fov` is horizontal, degrees.
export interface Vantage {
  position: Vector;
  turned: number[];
  fov: number;
}

export interface KeyFrame {
  time: number;  // seconds
  vantage: Vantage;
}

// Says whether a point of the surface is shown.
export type ShownPart = (x: number, y: number, z: number) => boolean;

// The actions of buttons and menus.
export interface Actions {
  mode(name: string): void;
  quality(name: string): void;
  jump(slot: number): void;
  save(): void;
  walk(): void;
  hold(): void;
  writeAddress(): void;  // the view, into the page's address
  memory(): string;  // a line about the GPU's memory
}

// MiB of GPU memory: what a model takes in all, what of it is the mesh, what is allowed, and what would be enough.
export interface Overrun {
  all: number;
  mesh: number;
  allowed: number;
  enough: number;
}
