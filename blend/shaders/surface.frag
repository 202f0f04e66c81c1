#version 300 es

#include "picture.glsl"
#include "surface_texel.glsl"

in vec3 linear_color;
in vec3 cell_shares;
flat in uint zone_of_face;

#ifdef LATE_STENCIL
uniform uint variant;  // which of the shaders for 1, 2 and 4 cells draws this face: 0, 1 or 2
#endif

layout(location = 0) out uvec4 texel;

void main() {
  texel = texel_of(Surface(zone_of_face, 1.0 / gl_FragCoord.w, vec4(cell_shares, 0.0), linear_color, false));
#ifdef LATE_STENCIL
  texel.w |= variant << 30;
#endif
#ifndef CLIP_CONTROL
  gl_FragDepth = exposure.w * gl_FragCoord.w;
#endif
}
