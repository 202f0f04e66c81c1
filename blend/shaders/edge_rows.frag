#version 300 es
// Spreads the variances of edges along rows.

#include "picture.glsl"
#include "edge_spread.glsl"

layout(location = 0) out uint variance;

void main() {
  float most = spread_along(ivec2(gl_FragCoord.xy), ivec2(1, 0));
  if (!(most > 0.0)) discard;
  variance = floatBitsToUint(most);
}
