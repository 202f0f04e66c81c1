#version 300 es
// Eight neighbouring depths of a stored view in one texel, each in half precision, rounded up, and negative at rims: as
// blend/photograph_array.cpp has them.
precision highp float;
precision highp int;
precision highp usampler2D;

#include "../../../../blend/shaders/surface_texel.glsl"

uniform usampler2D surfaces;  // first row below
uniform usampler2D mask;
uniform ivec2 size;         // of the view, pixels
uniform float depth_scale;  // what depths are shares of
uniform float pixels;       // of the mask in one of the view, along a side

layout(location = 0) out uvec4 packed;

const uint kNothing = 0xFFFFFFFFu;
const uint kInfinity = 0x7C00u;

uint half_above(float depth) {
  if (depth >= 6.103515625e-05 && depth <= 65504.0) {  // the normal numbers: cut the 13 bits that a half has not
    return (floatBitsToUint(depth) + 0x1FFFu >> 13) - (112u << 10);
  }
  return depth > 1.0 ? kInfinity : 0x0400u;
}

uint depth_at(ivec2 pixel) {
  ivec2 at = min(pixel, size - 1);
  uvec4 texel = texelFetch(surfaces, ivec2(at.x, size.y - 1 - at.y), 0);
  uint depth = texel.x == kNothing ? kInfinity : half_above(uintBitsToFloat(texel.y) / depth_scale);
  ivec2 of_mask = min(ivec2((vec2(at) + 0.5) * pixels), textureSize(mask, 0) - 1);
  return depth | texelFetch(mask, of_mask, 0).y << 15;
}

void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * ivec2(8, 1);
  uint pairs[4];
  for (int i = 0; i < 4; ++i) {
    pairs[i] = depth_at(first + ivec2(2 * i, 0)) | depth_at(first + ivec2(2 * i + 1, 0)) << 16;
  }
  packed = uvec4(pairs[0], pairs[1], pairs[2], pairs[3]);
}
