// SPDX-License-Identifier: GPL-3.0-or-later
// The forms in which the GPU holds photographs' texels: as they are, or in blocks of 4 x 4, for which there is a shader
// of that name. Most screens' GPUs know BC7, most phones' ETC2; both have 16 bytes a block.
import {TextError} from '../texts/texts.js';
/** @import {TexelForm} from '../types.d.ts' */

export const PLAIN = 'rgb8';
/** @type {Record<string, {extension: string, format: string}>} */
const BLOCKS = {
  bc7: {extension: 'EXT_texture_compression_bptc', format: 'COMPRESSED_SRGB_ALPHA_BPTC_UNORM_EXT'},
  etc2: {extension: 'WEBGL_compressed_texture_etc', format: 'COMPRESSED_SRGB8_ALPHA8_ETC2_EAC'},
};
const TEXEL_FORMS = ['auto', PLAIN, ...Object.keys(BLOCKS)];

/** @param {WebGL2RenderingContext} gl @param {string} name @returns {TexelForm | null} */
function blocksOf(gl, name) {
  const {extension, format} = BLOCKS[name];
  const known = gl.getExtension(extension);
  return known && {name, internal: known[format], texelBytes: 1, blocks: true};
}

// {name, internal, texelBytes, blocks}. `wanted`: 'auto' takes the first blocks that the device knows.
/** @param {WebGL2RenderingContext} gl @returns {TexelForm} */
export function texelForm(gl, wanted = 'auto') {
  if (!TEXEL_FORMS.includes(wanted)) throw new TextError('texelForms', {forms: TEXEL_FORMS.join(', '), wanted});
  const tried = Object.keys(BLOCKS).filter((name) => wanted === 'auto' || wanted === name);
  for (const name of tried) {
    const form = blocksOf(gl, name);
    if (form) return form;
  }
  if (wanted in BLOCKS) throw new TextError('noTexelForm', {form: wanted});
  return {name: PLAIN, internal: gl.SRGB8_ALPHA8, texelBytes: 4, blocks: false};
}
