// Depths of the surface around a pixel, see outlines.h.

uniform usampler2D surfaces;

const float kFarthest = 3e38;

// Returns the depth of the surface in the texel, kFarthest if there is none.
float depth_or_farthest(uvec4 texel) {
  return texel.x == kNothing ? kFarthest : uintBitsToFloat(texel.y);
}
