#version 450 core
// Lets those pixels pass that samples are taken of: at silhouettes, as silhouettes() in supersampling.cpp has it, or
// wherever the surface is seen.

layout(binding = 3) uniform sampler2D surface_depth;  // z; 0 where no surface is

uniform bool everywhere;
uniform float focal_length;  // pixels

bool at_silhouette(ivec2 pixel, float z) {
  ivec2 size = textureSize(surface_depth, 0);
  const ivec2 steps[4] = ivec2[](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(1, -1));
  for (int i = 0; i < 4; ++i) {
    float bend = -2.0;
    int inside = 0;
    for (int side = -1; side <= 1; side += 2) {
      ivec2 at = pixel + side * steps[i];
      if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) continue;
      float other = texelFetch(surface_depth, at, 0).x;
      if (!(other > 0.0)) return true;
      bend += z / other;
      ++inside;
    }
    if (inside == 2 && focal_length * abs(bend) > SILHOUETTE_BEND) return true;
  }
  return false;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float z = texelFetch(surface_depth, pixel, 0).x;
  if (!(z > 0.0) || !(everywhere || at_silhouette(pixel, z))) discard;
}
