// A cell of a picture's surroundings: a linear colour times its weight, and the weight, as halves. In the finest filled
// cells the surface's share stands in place of the weight.

const uint kOpen = 0x80000000u;  // sign of the weight: a pixel of the cell shows no surface

uvec2 packed_cell(vec4 cell) {
  return uvec2(packHalf2x16(cell.rg), packHalf2x16(cell.ba));
}

vec4 cell_of(uvec2 bits) {
  return vec4(unpackHalf2x16(bits.x), unpackHalf2x16(bits.y & ~kOpen));
}

// Bilinear between the middles of cells; `at` in cells.
vec4 between(usampler2D cells, vec2 at) {
  ivec2 last = textureSize(cells, 0) - 1;
  vec2 inside = clamp(at - 0.5, vec2(0.0), vec2(last));
  ivec2 first = ivec2(inside);
  vec2 f = inside - vec2(first);
  vec4 sum = vec4(0.0);
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = ivec2(i & 1, i >> 1);
    vec2 part = mix(1.0 - f, f, vec2(corner));
    sum += part.x * part.y * cell_of(texelFetch(cells, min(first + corner, last), 0).xy);
  }
  return sum;
}
