#version 300 es
// Writes the least depth along the pixel's row, at most OUTLINE_REACH away, as bits of a float.

#include "picture.glsl"
#include "surface_texel.glsl"
#include "outlines.glsl"

layout(location = 0) out uint nearest;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  int last = textureSize(surfaces, 0).x - 1;
  float least = kFarthest;
  for (int dx = -OUTLINE_REACH; dx <= OUTLINE_REACH; ++dx) {
    int x = clamp(pixel.x + dx, 0, last);
    least = min(least, depth_or_farthest(texelFetch(surfaces, ivec2(x, pixel.y), 0)));
  }
  nearest = floatBitsToUint(least);
}
