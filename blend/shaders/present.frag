#version 300 es
// Copies a drawn picture into a framebuffer that the caller owns: sRGB values unchanged. Pixels without a surface keep
// their value. In the variant HOST_DEPTH it writes their depths too, as the caller's depth buffer has them.

precision highp float;
precision highp sampler2D;
precision highp usampler2D;

uniform sampler2D shown;  // alpha: PixelState / 255
uniform ivec2 corner;     // lower left corner of the picture in the framebuffer

#ifdef HOST_DEPTH
uniform usampler2D surfaces;  // see surface_texel.glsl
uniform vec2 host_depth;      // at infinity, and per reciprocal of a depth in the camera frame
#endif

layout(location = 0) out vec4 color;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy) - corner;
  vec4 texel = texelFetch(shown, pixel, 0);
  if (texel.a == 0.0) discard;
  color = vec4(texel.rgb, 1.0);
#ifdef HOST_DEPTH
  float z = uintBitsToFloat(texelFetch(surfaces, pixel, 0).y);
  gl_FragDepth = clamp(host_depth.x + host_depth.y / z, 0.0, 1.0);
#endif
}
