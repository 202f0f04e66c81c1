#version 300 es
// A picture that is drawn, into somebody else's framebuffer: sRGB values as they are. Where no surface is, what is there
// stays.

precision highp float;
precision highp sampler2D;

uniform sampler2D shown;  // alpha: PixelState / 255
uniform ivec2 corner;     // of the picture in the framebuffer, lower left

layout(location = 0) out vec4 color;

void main() {
  vec4 texel = texelFetch(shown, ivec2(gl_FragCoord.xy) - corner, 0);
  if (texel.a == 0.0) discard;
  color = vec4(texel.rgb, 1.0);
}
