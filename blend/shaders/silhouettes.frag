#version 300 es
// Lets those pixels pass that samples are taken of: at silhouettes, as silhouettes() in supersampling.cpp has it, or
// wherever the surface is seen.

#include "picture.glsl"
#include "surface_texel.glsl"

uniform usampler2D surfaces;

// 0 where no surface is.
float depth_at(ivec2 pixel) {
  uvec4 texel = texelFetch(surfaces, pixel, 0);
  return texel.x == kNothing ? 0.0 : uintBitsToFloat(texel.y);
}

bool bends(ivec2 pixel, float z, ivec2 step_px, ivec2 size) {
  float bend = -2.0;
  int inside = 0;
  for (int side = -1; side <= 1; side += 2) {
    ivec2 at = pixel + side * step_px;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) continue;
    float other = depth_at(at);
    if (!(other > 0.0)) return true;
    bend += z / other;
    ++inside;
  }
  return inside == 2 && intrinsics.x * abs(bend) > SILHOUETTE_BEND;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  ivec2 size = textureSize(surfaces, 0);
  float z = depth_at(pixel);
  bool passes = z > 0.0 && (samples.z != 0 || bends(pixel, z, ivec2(1, 0), size) || bends(pixel, z, ivec2(0, 1), size) ||
                            bends(pixel, z, ivec2(1, 1), size) || bends(pixel, z, ivec2(1, -1), size));
  if (!passes) discard;
}
