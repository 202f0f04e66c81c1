// SPDX-License-Identifier: GPL-3.0-or-later
// Decodes buffer views that EXT_meshopt_compression compressed, in the forms that models are packed in.
// Source: the extension's page in the Khronos registry: modes 0 (attributes, version 0) and 1 (triangles, version 1),
// and filter 3 (exponential).

const GROUP = 16;          // values that are written with the same number of bits
const BITS = [0, 2, 4, 8];
const MOST_GROWTH = 64;    // no bytes decode to more than this many times as many
const EDGES = 16;
const VERTICES = 16;

/** @param {number} value */
const signed = (value) => (value >>> 1) ^ -(value & 1);

/** @param {boolean} holds @param {string} what */
function require(holds, what) {
  if (!holds) throw new Error(`its compressed bytes are damaged: ${what}`);
}

// Reads a group of one byte of each element, as differences, and returns where the next one begins.
/** @param {Uint8Array} source @param {number} at @param {number} bits @param {Uint8Array} group */
function readGroup(source, at, bits, group) {
  if (bits === 0) {
    group.fill(0);
    return at;
  }
  if (bits === 8) {
    group.set(source.subarray(at, at + GROUP));
    return at + GROUP;
  }
  const escape = (1 << bits) - 1;
  const perByte = 8 / bits;
  let more = at + GROUP / perByte;
  for (let i = 0; i < GROUP; ++i) {
    const shift = 8 - bits * (1 + i % perByte);
    const value = source[at + Math.floor(i / perByte)] >> shift & escape;
    group[i] = value === escape ? source[more++] : value;
  }
  return more;
}

/** @param {Uint8Array} source @param {number} count @param {number} stride */
export function decodedAttributes(source, count, stride) {
  require(source[0] === 0xA0 && stride > 0 && stride % 4 === 0 && stride <= 256, 'no attributes');
  require(count * stride <= MOST_GROWTH * source.length, 'too many elements');
  const target = new Uint8Array(count * stride);
  const last = source.slice(source.length - stride);
  const perBlock = Math.min(8192 / stride & ~(GROUP - 1), 256);
  const group = new Uint8Array(GROUP);
  let at = 1;
  for (let first = 0; first < count; first += perBlock) {
    const inBlock = Math.min(perBlock, count - first);
    const groups = Math.ceil(inBlock / GROUP);
    for (let byte = 0; byte < stride; ++byte) {
      const header = at;
      at += Math.ceil(groups / 4);
      for (let number = 0; number < groups; ++number) {
        require(at <= source.length, 'they end early');
        at = readGroup(source, at, BITS[source[header + (number >> 2)] >> 2 * (number & 3) & 3], group);
        const end = Math.min(GROUP, inBlock - GROUP * number);
        for (let i = 0; i < end; ++i) {
          last[byte] += signed(group[i]);
          target[(first + GROUP * number + i) * stride + byte] = last[byte];
        }
      }
    }
  }
  require(at + Math.max(stride, 32) === source.length, 'another length was expected');
  return target;
}

class TriangleDecoder {
  /** @param {Uint8Array} source @param {number} count */
  constructor(source, count) {
    require(source[0] === 0xE1 && count % 3 === 0 && count / 3 + 17 <= source.length, 'no triangles');
    this.source = source;
    this.at = 1 + count / 3;
    this.next = 0;
    this.last = 0;
    this.edges = new Uint32Array(2 * EDGES);
    this.edge = 0;
    this.vertices = new Uint32Array(VERTICES);
    this.vertex = 0;
    this.corners = new Uint32Array(count);
  }

  decode() {
    const {source, corners} = this;
    const pairs = source.length - 16;
    for (let i = 0; i < corners.length; i += 3) {
      const code = source[1 + i / 3];
      if (code < 0xF0) this.onEdge(i, code);
      else if (code < 0xFE) this.free(i, 0, source[pairs + (code & 15)], false);
      else this.free(i, code === 0xFE ? 0 : 15, source[this.at++], true);
    }
    require(this.at <= pairs, 'they end early');
    return corners;
  }

  // A face at an edge that came before.
  /** @param {number} i @param {number} code */
  onEdge(i, code) {
    const edge = 2 * ((this.edge - 1 - (code >> 4)) & (EDGES - 1));
    const [a, b] = [this.edges[edge], this.edges[edge + 1]];
    const how = code & 15;
    const c = this.third(how);
    if (how === 0 || how >= 13) this.pushVertex(c);
    this.pushEdge(c, b);
    this.pushEdge(a, c);
    this.corners.set([a, b, c], i);
  }

  // The corner of a face at an edge that is not on it.
  /** @param {number} how */
  third(how) {
    if (how === 0) return this.next++;
    if (how < 13) return this.vertices[(this.vertex - 1 - how) & (VERTICES - 1)];
    return how === 15 ? this.index() : (this.last += how === 13 ? -1 : 1);
  }

  // A face at no such edge. `restarts`: numbers may begin at 0 again.
  /** @param {number} i @param {number} first @param {number} others @param {boolean} restarts */
  free(i, first, others, restarts) {
    if (restarts && others === 0) this.next = 0;
    const corners = [first, others >> 4, others & 15];
    const old = this.vertex;
    const face = corners.map((how) => {
      if (how === 0) return this.next++;
      return how === 15 && restarts ? this.index() : this.vertices[(old - how) & (VERTICES - 1)];
    });
    corners.forEach((how, corner) => {
      if (how === 0 || (how === 15 && restarts)) this.pushVertex(face[corner]);
    });
    const [a, b, c] = face;
    this.pushEdge(b, a);
    this.pushEdge(c, b);
    this.pushEdge(a, c);
    this.corners.set(face, i);
  }

  index() {
    let value = 0;
    for (let shift = 0; shift < 35; shift += 7) {
      const byte = this.source[this.at++];
      value |= (byte & 127) << shift;
      if (byte < 128) return this.last += signed(value);
    }
    throw new Error('its compressed bytes are damaged: a number is too long');
  }

  /** @param {number} vertex */
  pushVertex(vertex) {
    this.vertices[this.vertex] = vertex;
    this.vertex = (this.vertex + 1) & (VERTICES - 1);
  }

  /** @param {number} a @param {number} b */
  pushEdge(a, b) {
    this.edges[2 * this.edge] = a;
    this.edges[2 * this.edge + 1] = b;
    this.edge = (this.edge + 1) & (EDGES - 1);
  }
}

/** @param {Uint8Array} source @param {number} count corners */
export const decodedTriangles = (source, count) => new TriangleDecoder(source, count).decode();

// Floats that are written as a mantissa of 24 bits and a power of two.
/** @param {Uint8Array<ArrayBuffer>} bytes */
export function exponentialFloats(bytes) {
  const words = new Int32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
  const floats = new Float32Array(words.length);
  for (let i = 0; i < words.length; ++i) floats[i] = (words[i] << 8 >> 8) * 2 ** (words[i] >> 24);
  return floats;
}
