// Says which pixels are means over samples: those at silhouettes, as silhouettes() in supersampling.cpp has it, or all
// that show a surface; and which samples of such a pixel are of one surface.

// 0 where no surface is.
float depth_at(usampler2D surfaces, ivec2 pixel) {
  uvec4 texel = texelFetch(surfaces, pixel, 0);
  return texel.x == kNothing ? 0.0 : uintBitsToFloat(texel.y);
}

bool is_continued_at(usampler2D surfaces, ivec2 pixel) {
  uvec4 texel = texelFetch(surfaces, pixel, 0);
  return texel.x != kNothing && (texel.w & kContinued) == kContinued;
}

bool bends(usampler2D surfaces, ivec2 pixel, float z, ivec2 step_px) {
  ivec2 size = textureSize(surfaces, 0);
  float bend = -2.0;
  int inside = 0;
  for (int side = -1; side <= 1; side += 2) {
    ivec2 at = pixel + side * step_px;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) continue;
    float other = depth_at(surfaces, at);
    if (!(other > 0.0)) return true;
    bend += z / other;
    ++inside;
  }
  return inside == 2 && intrinsics.x * abs(bend) > SILHOUETTE_BEND;
}

bool is_sampled(usampler2D surfaces, ivec2 pixel) {
  float z = depth_at(surfaces, pixel);
  if (!(z > 0.0)) return false;
  return samples.z != 0 || bends(surfaces, pixel, z, ivec2(1, 0)) || bends(surfaces, pixel, z, ivec2(0, 1)) ||
         bends(surfaces, pixel, z, ivec2(1, 1)) || bends(surfaces, pixel, z, ivec2(1, -1));
}

// Returns whether the surface at a sample with depth `other` counts as the one at a depth `z` of the same pixel.
bool is_same_surface(float z, float other) {
  return intrinsics.x * abs(z / other - 1.0) < SAME_SURFACE;
}
