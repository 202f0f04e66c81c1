// Returns the largest v - BLUR_FALL r^2 of the pixels at most EDGE_REACH away along a row or a column: see
// soft_edges.h.

uniform usampler2D variances;  // bits of floats; 0 where no edge is

float spread_along(ivec2 pixel, ivec2 step_px) {
  ivec2 last = textureSize(variances, 0) - 1;
  float most = 0.0;
  for (int r = -EDGE_REACH; r <= EDGE_REACH; ++r) {
    ivec2 at = pixel + r * step_px;
    if (at != clamp(at, ivec2(0), last)) continue;
    most = max(most, uintBitsToFloat(texelFetch(variances, at, 0).x) - BLUR_FALL * float(r * r));
  }
  return most;
}
