#version 300 es
// Lets those pixels pass that are means over samples.

#include "picture.glsl"
#include "surface_texel.glsl"
#include "silhouettes.glsl"

uniform usampler2D surfaces;

void main() {
  if (!is_sampled(surfaces, ivec2(gl_FragCoord.xy))) discard;
}
