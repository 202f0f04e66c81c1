// SPDX-License-Identifier: GPL-3.0-or-later
// The other half of packed_arrays.h.
/** @import {PackedArray} from './types.d.ts' */

/** @param {Uint8Array<ArrayBuffer>} bytes */
export async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/**
 * @param {Uint8Array} bytes
 * @param {number} at
 * @param {PackedArray} description
 * @param {number} component
 * @param {Uint32Array} values
 */
function unpackComponent(bytes, at, description, component, values) {
  const {components, entries, coding, bytes: planes} = description;
  let last = 0;
  for (let i = 0; i < entries; ++i) {
    let value = 0;
    for (let plane = 0; plane < planes; ++plane) value |= bytes[at + plane * entries + i] << (8 * plane);
    if (coding === 'difference') value = last = (last + ((value >>> 1) ^ -(value & 1))) | 0;
    values[i * components + component] = value;
  }
}

// Corners run on over the components of an entry, so they are told apart only once all are there.
/** @param {Uint32Array} values */
function resolveCorners(values) {
  let next = 0;
  for (let i = 0; i < values.length; ++i) {
    const below = values[i];
    values[i] = next - below;
    if (below === 0) ++next;
  }
}

// An array of whole numbers for each name.
/** @param {Uint8Array} bytes @param {PackedArray[]} descriptions */
export function unpack(bytes, descriptions) {
  /** @type {Record<string, Uint32Array<ArrayBuffer>>} */
  const arrays = {};
  let at = 0;
  for (const description of descriptions) {
    const {name, components, entries, coding, bytes: planes} = description;
    const values = new Uint32Array(components * entries);
    for (let component = 0; component < components; ++component, at += planes * entries) {
      unpackComponent(bytes, at, description, component, values);
    }
    if (coding === 'corners') resolveCorners(values);
    arrays[name] = values;
  }
  if (at !== bytes.length) throw new Error(`the file's arrays have ${at} bytes, it has ${bytes.length}`);
  return arrays;
}
