// The texels of a block, as a shader compresses them.
#include "photograph_texel.glsl"

const int kSide = 4;
const int kTexels = kSide * kSide;
// More than a block of the greatest errors: what is valid stays valid, and what is not, not.
const float kOtherMeaning = 1048576.0;

vec3 colors[kTexels];  // row by row, sRGB, [0, 255]
int alphas[kTexels];

void read_texels() {
  ivec2 first = kSide * ivec2(gl_FragCoord.xy);
  for (int i = 0; i < kTexels; ++i) {
    vec4 texel = photograph_texel(first + ivec2(i % kSide, i / kSide));
    colors[i] = floor(255.0 * srgb_from_linear(texel.rgb) + 0.5);
    alphas[i] = int(255.0 * texel.a + 0.5);
  }
}

float alpha_error(int value, int alpha) {
  float away = float(value - alpha);
  return away * away + ((value == 0) == (alpha == 0) ? 0.0 : kOtherMeaning);
}
