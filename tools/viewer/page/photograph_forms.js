// SPDX-License-Identifier: GPL-3.0-or-later
// How the GPU holds photographs' texels: as they are, or in blocks of 4 x 4 (atlas/compressed_texels.h).
export const TEXEL_FORMS = ['auto', 'rgb8', 'bc3'];

// {name, internal, texelBytes, blocks}. `wanted`: 'auto' takes blocks where the device knows them.
export function texelForm(gl, wanted = 'auto') {
  if (!TEXEL_FORMS.includes(wanted)) throw new Error(`texels are ${TEXEL_FORMS.join(', ')}, not "${wanted}"`);
  const blocks = wanted === 'rgb8' ? null : gl.getExtension('WEBGL_compressed_texture_s3tc_srgb');
  if (wanted === 'bc3' && !blocks) throw new Error('This device does not know texels of the form "bc3".');
  return blocks ? {name: 'bc3', internal: blocks.COMPRESSED_SRGB_ALPHA_S3TC_DXT5_EXT, texelBytes: 1, blocks: true} :
                  {name: 'rgb8', internal: gl.SRGB8_ALPHA8, texelBytes: 4, blocks: false};
}
