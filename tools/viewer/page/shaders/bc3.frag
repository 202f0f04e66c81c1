#version 300 es
// A block of 4 x 4 texels of a stored photograph in the form BC3, for a texture of sRGB: 8 bytes of alpha, two values
// and for each texel 3 bits between them, and 8 bytes of colour, two colours of 16 bits and for each texel 2 bits
// between them. Source: the extension EXT_texture_compression_s3tc.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

#include "block_texels.glsl"

layout(location = 0) out uvec4 block;

const int kPowerSteps = 4;    // by which the direction of the greatest spread is found
const int kRefinements = 3;   // of the two colours, by least squares
const vec3 kMost = vec3(31.0, 63.0, 31.0);

// Two colours of 5, 6 and 5 bits a channel, and for each texel which of the four between them it has.
struct Colors {
  vec3 first, second;  // whole numbers of bits
  uint codes;
  float error;
};

vec3 color_of_bits(vec3 bits) {
  ivec3 whole = ivec3(bits);
  return vec3((whole << ivec3(3, 2, 3)) | (whole >> ivec3(2, 4, 2)));
}

Colors coded(vec3 first, vec3 second) {
  vec3 from = color_of_bits(first), to = color_of_bits(second);
  vec3 palette[4] = vec3[](from, to, floor((2.0 * from + to) / 3.0), floor((from + 2.0 * to) / 3.0));
  Colors result = Colors(first, second, 0u, 0.0);
  for (int i = 0; i < kTexels; ++i) {
    float least = 1e9;
    uint code = 0u;
    for (int j = 0; j < 4; ++j) {
      vec3 away = palette[j] - colors[i];
      float error = dot(away, away);
      if (error < least) {
        least = error;
        code = uint(j);
      }
    }
    result.codes |= code << (2 * i);
    result.error += least;
  }
  return result;
}

vec3 bits_of_color(vec3 color) {
  return floor(clamp(color, 0.0, 255.0) / 255.0 * kMost + 0.5);
}

// Along the direction in which the colours differ most.
Colors coded_along_spread(vec3 mean) {
  mat3 spread = mat3(0.0);
  for (int i = 0; i < kTexels; ++i) spread += outerProduct(colors[i] - mean, colors[i] - mean);
  vec3 axis = vec3(spread[0][0], spread[1][1], spread[2][2]);
  axis = axis.x >= axis.y && axis.x >= axis.z ? spread[0] : axis.y >= axis.z ? spread[1] : spread[2];
  for (int i = 0; i < kPowerSteps; ++i) axis = spread * axis / max(length(axis), 1e-6);
  axis /= max(length(axis), 1e-6);
  float least = 0.0, most = 0.0;
  for (int i = 0; i < kTexels; ++i) {
    float at = dot(colors[i] - mean, axis);
    least = min(least, at);
    most = max(most, at);
  }
  return coded(bits_of_color(mean + most * axis), bits_of_color(mean + least * axis));
}

// The two colours that are nearest to the texels with the codes that these have.
Colors refined(Colors before) {
  vec3 sums = vec3(0.0);  // of the shares' squares and products
  vec3 by_first = vec3(0.0), by_second = vec3(0.0);
  for (int i = 0; i < kTexels; ++i) {
    uint code = before.codes >> (2 * i) & 3u;
    float share = code == 0u ? 1.0 : code == 1u ? 0.0 : code == 2u ? 2.0 / 3.0 : 1.0 / 3.0;
    sums += vec3(share * share, (1.0 - share) * (1.0 - share), share * (1.0 - share));
    by_first += share * colors[i];
    by_second += (1.0 - share) * colors[i];
  }
  float determinant = sums.x * sums.y - sums.z * sums.z;
  if (determinant < 1e-3) return before;
  return coded(bits_of_color((sums.y * by_first - sums.z * by_second) / determinant),
               bits_of_color((sums.x * by_second - sums.z * by_first) / determinant));
}

// One colour for all, between two near ones: finer than 5 and 6 bits.
Colors coded_as_one(vec3 color) {
  vec3 least = vec3(1e9), first = vec3(0.0), second = vec3(0.0);
  vec3 middle = floor(color / 255.0 * kMost);
  for (int i = -2; i <= 3; ++i) {
    for (int j = -2; j <= 3; ++j) {
      vec3 a = clamp(middle + float(i), vec3(0.0), kMost), b = clamp(middle + float(j), vec3(0.0), kMost);
      vec3 error = abs(floor((2.0 * color_of_bits(a) + color_of_bits(b)) / 3.0) - color);
      bvec3 better = lessThan(error, least);
      least = mix(least, error, better);
      first = mix(first, a, better);
      second = mix(second, b, better);
    }
  }
  return coded(first, second);
}

uint bits_565(vec3 bits) {
  uvec3 whole = uvec3(bits);
  return whole.x << 11 | whole.y << 5 | whole.z;
}

uvec2 color_block() {
  vec3 mean = vec3(0.0);
  for (int i = 0; i < kTexels; ++i) mean += colors[i] / float(kTexels);
  Colors best = coded_along_spread(mean);
  Colors next = best;
  for (int i = 0; i < kRefinements; ++i) {
    next = refined(next);
    if (!(next.error < best.error)) break;
    best = next;
  }
  next = coded_as_one(mean);
  if (next.error < best.error) best = next;
  uint first = bits_565(best.first), second = bits_565(best.second);
  // The other order has another meaning in formats without alpha, which not all devices tell apart.
  if (first < second) return uvec2(second | first << 16, best.codes ^ 0x55555555u);
  return uvec2(first | second << 16, first == second ? 0u : best.codes);
}

struct Alphas {
  int first, second;
  uvec2 codes;  // 3 bits a texel
  float error;
};

// With the first value above the second six values between both; else four, and 0 and 255.
int alpha_of_code(int first, int second, int code) {
  if (code == 0) return first;
  if (code == 1) return second;
  int steps = first > second ? 7 : 5;
  if (code > steps) return code == 6 ? 0 : 255;
  return ((steps + 1 - code) * first + (code - 1) * second) / steps;
}

// The nearest value for each texel; those that are shown stay shown, and those that are not, not.
Alphas coded_alphas(int first, int second) {
  Alphas result = Alphas(first, second, uvec2(0u), 0.0);
  for (int i = 0; i < kTexels; ++i) {
    float least = 4.0 * kOtherMeaning;
    uint code = 0u;
    for (int j = 0; j < 8; ++j) {
      float error = alpha_error(alpha_of_code(first, second, j), alphas[i]);
      if (error < least) {
        least = error;
        code = uint(j);
      }
    }
    int bit = 3 * i;
    result.codes.x |= bit < 32 ? code << bit : 0u;
    if (bit >= 32) {
      result.codes.y |= code << (bit - 32);
    } else if (bit > 29) {
      result.codes.y |= code >> (32 - bit);
    }
    result.error += least;
  }
  return result;
}

// The better one of the ranges with and without a 0 and a 255 of their own.
Alphas best_alphas() {
  int least = 255, most = 0, least_between = 255, most_between = 0;
  for (int i = 0; i < kTexels; ++i) {
    int alpha = alphas[i];
    least = min(least, alpha);
    most = max(most, alpha);
    if (alpha == 0 || alpha == 255) continue;
    least_between = min(least_between, alpha);
    most_between = max(most_between, alpha);
  }
  if (most_between == 0) least_between = most_between = most;
  Alphas between = coded_alphas(least_between, most_between);
  if (between.error == 0.0) return between;
  Alphas over_all = coded_alphas(most, least);
  if (over_all.error < between.error) return over_all;
  return between;
}

void main() {
  read_texels();
  Alphas alpha = best_alphas();
  uvec2 color = color_block();
  block = uvec4(uint(alpha.first) | uint(alpha.second) << 8 | alpha.codes.x << 16,
                alpha.codes.x >> 16 | alpha.codes.y << 16, color);
}
