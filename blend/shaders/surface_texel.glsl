// The output of the first pass for the visible surface at a pixel, in one texel of GL_RGBA32UI, which every OpenGL ES
// 3.0 can draw to: zone, z, shares of the zone's first three cells, fallback colour.
struct Surface {
  uint zone;      // kNothing: no surface
  float z;        // in the camera frame
  vec4 shares;    // shares of the zone's cells
  vec3 fallback;  // the vertices' colour, linear
  bool is_continued;  // past its outline, see outlines.h
};

// In the last word of pixels that a surface is continued to past its outline; also CELLS of the variant, as below.
const uint kContinued = 3u << 30;

uint bits_of(float value, uint most) {
  return uint(clamp(value, 0.0, 1.0) * float(most) + 0.5);
}

float value_of(uint bits, uint most) {
  return float(bits & most) / float(most);
}

uvec4 texel_of(Surface surface) {
  // Square roots, for 10 bits of linear light are too few in the dark.
  vec3 root = sqrt(max(surface.fallback, vec3(0.0)));
  return uvec4(surface.zone, floatBitsToUint(surface.z),
               bits_of(surface.shares.x, 2047u) | bits_of(surface.shares.y, 2047u) << 11 |
                   bits_of(surface.shares.z, 1023u) << 22,
               bits_of(root.x, 1023u) | bits_of(root.y, 1023u) << 10 | bits_of(root.z, 1023u) << 20);
}

// The last share is what the others leave; a cell that the zone does not have refers to nothing and has no say.
Surface surface_of(uvec4 texel) {
  vec3 shares = vec3(value_of(texel.z, 2047u), value_of(texel.z >> 11, 2047u), value_of(texel.z >> 22, 1023u));
  vec3 root = vec3(value_of(texel.w, 1023u), value_of(texel.w >> 10, 1023u), value_of(texel.w >> 20, 1023u));
  return Surface(texel.x, uintBitsToFloat(texel.y), vec4(shares, max(0.0, 1.0 - shares.x - shares.y - shares.z)),
                 root * root, (texel.w & kContinued) == kContinued);
}

// Returns CELLS of the variant that draws a pixel: see LATE_STENCIL in surface.frag. 0: there is no surface.
int variant_of(uvec4 texel) {
  return texel.x == kNothing ? 0 : 1 << min(texel.w >> 30, 2u);
}
