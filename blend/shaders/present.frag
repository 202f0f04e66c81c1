#version 300 es
// Copies a drawn picture into a framebuffer that the caller owns: sRGB values unchanged. Pixels without a surface keep
// their value.

precision highp float;
precision highp sampler2D;

uniform sampler2D shown;  // alpha: PixelState / 255
uniform ivec2 corner;     // lower left corner of the picture in the framebuffer

layout(location = 0) out vec4 color;

void main() {
  vec4 texel = texelFetch(shown, ivec2(gl_FragCoord.xy) - corner, 0);
  if (texel.a == 0.0) discard;
  color = vec4(texel.rgb, 1.0);
}
