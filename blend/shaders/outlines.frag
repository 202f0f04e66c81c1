#version 300 es
// Replaces the surface of pixels that the outline of a nearer one is continued to, and discards all others: see
// outlines.h.

#include "picture.glsl"
#include "surface_texel.glsl"
#include "tables.glsl"
#include "outlines.glsl"

uniform usampler2D row_depths;  // of outline_rows.frag; as large as the picture, unlike the target of the surfaces
uniform float most_deviation;   // scene units; more of a surface's deviation does not count

layout(location = 0) out uvec4 texel;

// Returns the reach of the outlines of a surface, pixels.
float outline_reach(uint zone, float z) {
  float shift = min(deviation_of(entry(zones, zone)), most_deviation) * SOFT_EDGE_SINE * intrinsics.x / z;
  return shift > 1.0 ? min(OUTLINE_OF_SHIFT * shift, float(OUTLINE_REACH)) : 0.0;
}

// Returns the least depth around the pixel, or one that is nearer still.
float least_around(ivec2 pixel) {
  int last = textureSize(row_depths, 0).y - 1;
  float least = kFarthest;
  for (int dy = -OUTLINE_REACH; dy <= OUTLINE_REACH; ++dy) {
    int y = clamp(pixel.y + dy, 0, last);
    least = min(least, uintBitsToFloat(texelFetch(row_depths, ivec2(pixel.x, y), 0).x));
  }
  return least;
}

// Returns the pixel whose surface is continued to this one of depth z, or this one.
ivec2 source_of(ivec2 pixel, float z) {
  ivec2 last = textureSize(row_depths, 0) - 1;
  ivec2 from = pixel;
  int least = 0;        // the square of the distance
  float nearest = 0.0;  // depth
  for (int dy = -OUTLINE_REACH; dy <= OUTLINE_REACH; ++dy) {
    for (int dx = -OUTLINE_REACH; dx <= OUTLINE_REACH; ++dx) {
      ivec2 at = clamp(pixel + ivec2(dx, dy), ivec2(0), last);
      uvec4 beside = texelFetch(surfaces, at, 0);
      float other = depth_or_farthest(beside);
      if (!(z > (1.0 + OUTLINE_STEP) * other)) continue;
      ivec2 away = at - pixel;
      int squared = away.x * away.x + away.y * away.y;
      float reach = outline_reach(beside.x, other);
      if (float(squared) > reach * reach) continue;
      if (from != pixel && (squared > least || (squared == least && other >= nearest))) continue;
      from = at;
      least = squared;
      nearest = other;
    }
  }
  return from;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uvec4 here = texelFetch(surfaces, pixel, 0);
  float z = depth_or_farthest(here);
  ivec2 from = pixel;
  // A renderer in software takes both sides of a branch, but leaves a loop that no pixel is in.
  for (bool may = here.x != kNothing && z > (1.0 + OUTLINE_STEP) * least_around(pixel); may; may = false) {
    from = source_of(pixel, z);
  }
  if (from == pixel) discard;
  texel = texelFetch(surfaces, from, 0);
  texel.w |= kContinued;
}
