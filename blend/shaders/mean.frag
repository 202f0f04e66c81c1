#version 450 core
// Last pass of a supersampled picture: its colour becomes the mean of each pixel's samples, see supersampling.h. Where
// none sees the surface, or none was taken, it stays.

layout(binding = 6) uniform sampler2D samples;  // sums of what blend.frag's variant SAMPLE leaves

layout(location = 0) out vec4 picture;  // sRGB, in the variant LINEAR linear light; alpha stays what it was

#include "srgb.glsl"

void main() {
  vec4 sum = texelFetch(samples, ivec2(gl_FragCoord.xy), 0);
  if (!(sum.a > 0.0)) discard;
  vec3 mean = sum.rgb / sum.a;
#ifdef LINEAR
  picture = vec4(mean, 1.0);
#else
  picture = vec4(srgb_from_linear(mean), 1.0);
#endif
}
