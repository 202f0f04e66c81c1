#version 300 es
// Spreads the variances of edges along columns, and blurs the picture by them: see soft_edges.h.

#include "picture.glsl"
#include "edge_spread.glsl"
#include "srgb.glsl"

uniform sampler2D sharp;  // the picture before: sRGB, in the variant LINEAR linear light; alpha 0: no surface

layout(location = 0) out vec4 picture;

vec3 light_of(vec3 color) {
#ifdef LINEAR
  return color;
#else
  return near_linear_from_srgb(color);
#endif
}

// With 1, or 0 where there is no surface.
vec4 light_at(ivec2 pixel) {
  vec4 color = texelFetch(sharp, pixel, 0);
  return color.a > 0.0 ? vec4(light_of(color.rgb), 1.0) : vec4(0.0);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float variance = spread_along(pixel, ivec2(0, 1));
  if (!(variance > 0.0) || !(texelFetch(sharp, pixel, 0).a > 0.0)) discard;
  ivec2 last = textureSize(sharp, 0) - 1;
  ivec2 from = max(pixel - EDGE_REACH, ivec2(0)), to = min(pixel + EDGE_REACH, last);
  vec4 sum = vec4(0.0);
  for (int y = from.y; y <= to.y; ++y) {
    float away = float(y - pixel.y);
    float weight = exp(-0.5 * away * away / variance);
    float ratio = exp(-0.5 / variance);
    for (int r = 0; r <= EDGE_REACH; ++r) {
      if (pixel.x - r >= from.x) sum += weight * light_at(ivec2(pixel.x - r, y));
      if (r > 0 && pixel.x + r <= to.x) sum += weight * light_at(ivec2(pixel.x + r, y));
      weight *= ratio;  // which falls by the same factor from each pixel to the next
      ratio *= exp(-1.0 / variance);
    }
  }
  vec3 light = sum.rgb / sum.w;
#ifdef LINEAR
  picture = vec4(light, 0.0);
#else
  picture = vec4(srgb_from_linear(light), 0.0);
#endif
}
