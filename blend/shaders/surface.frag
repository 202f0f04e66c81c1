#version 300 es

#include "picture.glsl"
#include "surface_texel.glsl"

in vec3 linear_color;
in vec3 cell_shares;
flat in uint zone_of_face;

layout(location = 0) out uvec4 texel;

void main() {
  texel = texel_of(Surface(zone_of_face, 1.0 / gl_FragCoord.w, vec4(cell_shares, 0.0), linear_color));
#ifndef CLIP_CONTROL
  gl_FragDepth = exposure.w * gl_FragCoord.w;
#endif
}
