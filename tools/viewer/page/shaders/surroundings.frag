#version 300 es
// Continues a picture's colours beyond its surface by pull and push, as tools/frame/background.cpp does. In the variant
// GATHER, pixels become cells, whose first row is the picture's top. In the variant HALVE, four cells become one.
// Otherwise, what a cell lacks comes from the coarser cells around it.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

#include "../../../../blend/shaders/srgb.glsl"
#include "surroundings.glsl"

layout(location = 0) out uvec2 bits;

#if defined(GATHER)

uniform sampler2D image;  // sRGB; alpha: PixelState / 255, or 1
uniform int cell_px;

const float kPhotographed = 2.5 / 255.0;
const float kGuess = 0.01;  // weight of a colour that no photograph shows

void main() {
  ivec2 size = textureSize(image, 0);
  ivec2 first = cell_px * ivec2(gl_FragCoord.xy);
  ivec2 end = min(first + cell_px, size);
  vec4 sum = vec4(0.0);
  bool open = false;
  for (int y = first.y; y < end.y; ++y) {
    for (int x = first.x; x < end.x; ++x) {
      vec4 texel = texelFetch(image, ivec2(x, size.y - 1 - y), 0);
      open = open || texel.a == 0.0;
      if (texel.a > 0.0) sum += (texel.a > kPhotographed ? 1.0 : kGuess) * vec4(linear_from_srgb(texel.rgb), 1.0);
    }
  }
  bits = packed_cell(sum / max(sum.a, 1.0));
  if (open) bits.y |= kOpen;
}

#elif defined(HALVE)

uniform usampler2D fine;

void main() {
  ivec2 first = 2 * ivec2(gl_FragCoord.xy);
  ivec2 end = min(first + 2, textureSize(fine, 0));
  vec4 sum = vec4(0.0);
  for (int y = first.y; y < end.y; ++y) {
    for (int x = first.x; x < end.x; ++x) sum += cell_of(texelFetch(fine, ivec2(x, y), 0).xy);
  }
  bits = packed_cell(sum / max(sum.a, 1.0));
}

#else

uniform usampler2D fine, coarse;
uniform bool is_coarsest;
uniform float soft_cells;  // over which the surface fades; 0: these are not the finest cells

const int kReach = 4;      // cells, at least soft_cells

// The surface's share of a cell, which rises with the distance from pixels without surface.
float surface_share(ivec2 cell) {
  ivec2 last = textureSize(fine, 0) - 1;
  float nearest = float(kReach);
  for (int y = -kReach; y <= kReach; ++y) {
    for (int x = -kReach; x <= kReach; ++x) {
      uint beside = texelFetch(fine, clamp(cell + ivec2(x, y), ivec2(0), last), 0).y;
      if ((beside & kOpen) != 0u) nearest = min(nearest, length(vec2(x, y)));
    }
  }
  return min(nearest / soft_cells, 1.0);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 cell = cell_of(texelFetch(fine, pixel, 0).xy);
  if (is_coarsest) {
    cell /= cell.a > 0.0 ? cell.a : 1.0;
  } else if (cell.a < 1.0) {
    cell += (1.0 - cell.a) * between(coarse, (vec2(pixel) + 0.5) / 2.0);
  }
  // A picture without any surface has no colours to continue.
  if (soft_cells > 0.0) cell.a = cell.a < 0.5 ? -1.0 : surface_share(pixel);
  bits = packed_cell(cell);
}

#endif
