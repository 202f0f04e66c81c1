#version 300 es
// Writes v of soft_edges.h at depth edges, as bits of a float, and discards all other pixels.

#include "picture.glsl"
#include "surface_texel.glsl"
#include "tables.glsl"

uniform usampler2D surfaces;
uniform float most_deviation;  // scene units; more of a surface's deviation does not count

layout(location = 0) out uint variance;

float edge_variance(uint zone, float z) {
  float off = min(deviation_of(entry(zones, zone)), most_deviation);
  float shift = off * SOFT_EDGE_SINE * intrinsics.x / z;
  return clamp(shift * shift - 1.0, 0.0, MOST_EDGE_BLUR * MOST_EDGE_BLUR);
}

void look_along(ivec2 pixel, ivec2 step_px, uvec2 here, inout float most) {
  ivec2 before = pixel - step_px, after = pixel + step_px;
  if (any(lessThan(before, ivec2(0))) || any(greaterThanEqual(after, textureSize(surfaces, 0)))) return;
  uvec2 a = texelFetch(surfaces, before, 0).xy, b = texelFetch(surfaces, after, 0).xy;
  if (a.x == kNothing || b.x == kNothing) return;
  float z = uintBitsToFloat(here.y), of_a = uintBitsToFloat(a.y), of_b = uintBitsToFloat(b.y);
  if (!(abs(z / of_a + z / of_b - 2.0) > EDGE_BEND)) return;
  uvec2 nearest = of_a < z ? a : here;
  if (of_b < uintBitsToFloat(nearest.y)) nearest = b;
  most = max(most, edge_variance(nearest.x, uintBitsToFloat(nearest.y)));
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uvec2 here = texelFetch(surfaces, pixel, 0).xy;
  float most = 0.0;
  if (here.x != kNothing) {
    look_along(pixel, ivec2(1, 0), here, most);
    look_along(pixel, ivec2(0, 1), here, most);
  }
  if (!(most > 0.0)) discard;
  variance = floatBitsToUint(most);
}
