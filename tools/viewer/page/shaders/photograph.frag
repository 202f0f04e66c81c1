#version 300 es
// A texel of a stored photograph. The texture is of sRGB, which GL makes of the linear light that is written.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

#include "photograph_texel.glsl"

uniform ivec2 origin;  // the view's in the page, at this level

layout(location = 0) out vec4 texel;

void main() {
  texel = photograph_texel(ivec2(gl_FragCoord.xy) - origin);
}
