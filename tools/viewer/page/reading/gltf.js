// SPDX-License-Identifier: GPL-3.0-or-later
// glTF 2.0 files with their buffers: .gltf, or .glb whole or in parts. Numbers in a file are checked before they are
// used: it may be anybody's.
import {decodedAttributes, decodedTriangles, exponentialFloats} from './meshopt.js';
/** @import {SiteFiles} from './site_files.js' */
/** @import {GltfJson, GltfView} from '../types.d.ts' */

const MESHOPT = 'EXT_meshopt_compression';
const HEADER_BYTES = 12;
const CHUNK_HEADER_BYTES = 8;
const JSON_CHUNK = 0x4E4F534A;
const BINARY_CHUNK = 0x004E4942;

/** @type {Record<string, number>} */
const COMPONENTS = {SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4};
/** @typedef {Uint8Array<ArrayBuffer> | Uint16Array<ArrayBuffer>} SmallValues */
/** @typedef {SmallValues | Uint32Array<ArrayBuffer> | Float32Array<ArrayBuffer>} Values */
/** @type {Record<number, {new(buffer: ArrayBuffer, at: number, length: number): Values, BYTES_PER_ELEMENT: number}>} */
const ARRAYS = {5121: Uint8Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array};

/** @param {Uint8Array} bytes */
const jsonOf = (bytes) => JSON.parse(new TextDecoder().decode(bytes));

// The length of the JSON of a .glb, by its first bytes.
/** @param {Uint8Array} bytes */
function jsonLength(bytes) {
  const words = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  if (bytes.length < 20 || words.getUint32(0, true) !== 0x46546C67 || words.getUint32(4, true) !== 2) {
    throw new Error('it is no .glb of glTF 2.0');
  }
  if (words.getUint32(16, true) !== JSON_CHUNK) throw new Error('its first chunk is not JSON');
  return words.getUint32(12, true);
}

// The offset at which the binary chunk of a .glb begins.
/** @param {number} jsonBytes */
const binaryAt = (jsonBytes) => HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + jsonBytes;

export class Gltf {
  // `binary`: the bytes of the binary chunk. Null: they are in the file from `at` on, or there are none.
  /**
   * @param {SiteFiles} files
   * @param {string} name
   * @param {GltfJson} json
   * @param {Uint8Array<ArrayBuffer> | null} binary
   * @param {number} at
   */
  constructor(files, name, json, binary, at) {
    this.files = files;
    this.name = name;
    this.json = json;
    this.binary = binary;
    this.at = at;
    /** @type {Map<number, Uint8Array<ArrayBuffer>>} */
    this.bytes = new Map();  // of buffer views, by their numbers
    /** @type {Map<number, Promise<void>>} */
    this.coming = new Map();  // the reading of buffer views, which may have ended
  }

  // A whole .glb, or a .gltf, whose buffers are read when they are needed.
  /** @param {SiteFiles} files @param {string} name */
  static read(files, name) {
    return files.smallArray(name, async (bytes) => {
      if (!name.endsWith('.glb')) return new Gltf(files, name, jsonOf(bytes), null, 0);
      const json = jsonLength(bytes);
      if (new DataView(bytes.buffer, bytes.byteOffset).getUint32(8, true) !== bytes.length) {
        throw new Error('it is cut off');
      }
      const text = jsonOf(bytes.subarray(HEADER_BYTES + CHUNK_HEADER_BYTES, HEADER_BYTES + CHUNK_HEADER_BYTES + json));
      return new Gltf(files, name, text, bytes.subarray(binaryAt(json)), 0);
    });
  }

  // The JSON of a .glb, of which other parts are read when they are needed.
  /** @param {SiteFiles} files @param {string} name @param {boolean} anew */
  static async readInParts(files, name, anew) {
    const start = `${name}#0+${HEADER_BYTES + CHUNK_HEADER_BYTES}`;
    const length = await files.array(start, async (bytes) => jsonLength(bytes), anew);
    const part = `${name}#${HEADER_BYTES + CHUNK_HEADER_BYTES}+${length + CHUNK_HEADER_BYTES}`;
    const json = await files.array(part, async (bytes) => {
      const type = new DataView(bytes.buffer, bytes.byteOffset + length + 4).getUint32(0, true);
      if (type !== BINARY_CHUNK) throw new Error('its second chunk is not binary');
      return jsonOf(bytes.subarray(0, length));
    }, anew);
    return new Gltf(files, name, json, null, binaryAt(length));
  }

  // The name of the file, or part of one, that an image is in.
  /** @param {number} number */
  imageName(number) {
    const image = this.json.images?.[number];
    if (!image) throw new Error(`${this.name} has no image ${number}`);
    if (image.uri !== undefined) return image.uri;
    const {byteOffset = 0, byteLength} = this.view(image.bufferView ?? -1);
    return `${this.name}#${this.at + byteOffset}+${byteLength}`;
  }

  // Returns a name of the content of an accessor's buffer.
  /** @param {number} number */
  bufferName(number) {
    const {bufferView} = this.accessor(number);
    return this.json.buffers?.[this.placeOf(bufferView ?? -1).buffer]?.uri ?? this.name;
  }

  /** @param {number} number @returns {GltfView} */
  view(number) {
    const view = this.json.bufferViews?.[number];
    if (!view) throw new Error(`${this.name} has no buffer view ${number}`);
    return view;
  }

  /** @param {number} number */
  accessor(number) {
    const accessor = this.json.accessors?.[number];
    if (!accessor) throw new Error(`${this.name} has no accessor ${number}`);
    return accessor;
  }

  // The part of a buffer that a view is in, compressed or not.
  /** @param {number} number */
  placeOf(number) {
    const view = this.view(number);
    const {buffer, byteOffset = 0, byteLength} = view.extensions?.[MESHOPT] ?? view;
    return {buffer, from: byteOffset, to: byteOffset + byteLength};
  }

  // Reads the bytes of accessors that values() is then asked for. Two calls at the same time read none of them twice.
  /** @param {number[]} accessors */
  async load(accessors) {
    const {coming} = this;
    const views = [...new Set(accessors.map((number) => this.accessor(number).bufferView ?? -1))];
    const missing = views.filter((view) => !coming.has(view)).map((view) => ({view, ...this.placeOf(view)}));
    for (const buffer of new Set(missing.map((place) => place.buffer))) {
      const places = missing.filter((place) => place.buffer === buffer);
      const loaded = this.loadPlaces(buffer, places);
      for (const {view} of places) coming.set(view, loaded);
    }
    await Promise.all(views.map((view) => coming.get(view)));
  }

  // Reads the bytes of buffer views that are in one buffer.
  /** @param {number} buffer @param {{view: number, from: number, to: number}[]} places */
  async loadPlaces(buffer, places) {
    try {
      const from = Math.min(...places.map((place) => place.from));
      const bytes = await this.part(buffer, from, Math.max(...places.map((place) => place.to)));
      for (const place of places) this.bytes.set(place.view, bytes.subarray(place.from - from, place.to - from));
    } catch (error) {
      for (const {view} of places) this.coming.delete(view);
      throw error;
    }
  }

  /** @param {number} buffer @param {number} from @param {number} to */
  async part(buffer, from, to) {
    const uri = this.json.buffers?.[buffer]?.uri;
    if (uri !== undefined) return this.files.smallArray(uri, async (bytes) => bytes.subarray(from, to));
    if (this.binary) return this.binary.subarray(from, to);
    return this.files.array(`${this.name}#${this.at + from}+${to - from}`, async (bytes) => bytes);
  }

  // The values of an accessor, one after the other. Throws unless they are of that type.
  /** @param {number} number @param {number} component @param {string} type @returns {Values} */
  values(number, component, type) {
    const {bufferView = -1, byteOffset = 0, componentType, count, type: given} = this.accessor(number);
    if (componentType !== component || given !== type) {
      throw new Error(`${this.name}: accessor ${number} has another type than models have`);
    }
    const length = count * COMPONENTS[type];
    const bytes = this.decoded(bufferView);
    const array = ARRAYS[component];
    if (!(byteOffset >= 0) || byteOffset + length * array.BYTES_PER_ELEMENT > bytes.byteLength) {
      throw new Error(`${this.name}: accessor ${number} reaches beyond its buffer view`);
    }
    const at = bytes.byteOffset + byteOffset;
    if (at % array.BYTES_PER_ELEMENT === 0) return new array(bytes.buffer, at, length);
    return new array(bytes.slice(byteOffset, byteOffset + length * array.BYTES_PER_ELEMENT).buffer, 0, length);
  }

  /** @param {number} number */
  decoded(number) {
    const bytes = this.bytes.get(number);
    const view = this.view(number);
    if (!bytes) throw new Error(`${this.name}: buffer view ${number} is not there`);
    const compression = view.extensions?.[MESHOPT];
    if (!compression) return bytes;
    const {mode, filter, count, byteStride} = compression;
    if (mode === 'TRIANGLES' && byteStride === 4) return new Uint8Array(decodedTriangles(bytes, count).buffer);
    if (mode !== 'ATTRIBUTES') throw new Error(`${this.name}: the mode ${mode} is not known`);
    const decoded = decodedAttributes(bytes, count, byteStride);
    return filter === 'EXPONENTIAL' ? new Uint8Array(exponentialFloats(decoded).buffer) : decoded;
  }

  // Forgets the bytes that were read.
  release() {
    this.bytes.clear();
    this.coming.clear();
  }
}
