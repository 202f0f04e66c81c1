#version 300 es
// A block of 4 x 4 texels of a stored photograph in the form ETC2 with EAC alpha, for a texture of sRGB.
// Source: the OpenGL ES 3.0 specification, appendix C; its modes T and H are not used.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

#include "block_texels.glsl"

layout(location = 0) out uvec4 block;

// A half of a block has a base and for each texel one of four steps of brightness from it, less or more, which a table
// says.
const vec2 kModifiers[8] = vec2[](vec2(2.0, 8.0), vec2(5.0, 17.0), vec2(9.0, 29.0), vec2(13.0, 42.0), vec2(18.0, 60.0),
                                  vec2(24.0, 80.0), vec2(33.0, 106.0), vec2(47.0, 183.0));
const int kHalfTexels = kTexels / 2;
const int kRounds = 2;  // in which base and codes of a half follow each other
// The most that a channel of a base may be: of two bases, and of a base and how much the other one differs from it.
const float kMostOfTwo = 15.0, kMostOfPair = 31.0;

// Returns the number of a texel in a block of the form, whose order is column by column.
int position(ivec2 place) {
  return kSide * place.x + place.y;
}

// Returns the place of a half's texel. Halves are left and right, or, flipped, above and below.
ivec2 place_in_half(bool flipped, int second, int texel) {
  ivec2 place = ivec2(texel % 2 + 2 * second, texel / 2);
  return flipped ? place.yx : place;
}

vec3 color_at(ivec2 place) {
  return colors[kSide * place.y + place.x];
}

float brightness(vec3 color) {
  return dot(color, vec3(1.0 / 3.0));
}

struct Half {
  vec3 base;  // whole numbers of bits
  int table;
  uint codes;
  float error;
};

vec3 color_of_base(vec3 base, float most) {
  ivec3 whole = ivec3(base);
  return vec3(most == kMostOfTwo ? 17 * whole : whole << 3 | whole >> 2);
}

vec3 base_of_color(vec3 color, float most) {
  return floor(clamp(color, 0.0, 255.0) * (most / 255.0) + 0.5);
}

// `shift`: by how much the modifiers brighten, in the mean.
Half coded_half(bool flipped, int second, vec3 base, float most, int table, out float shift) {
  Half result = Half(base, table, 0u, 0.0);
  vec3 middle = color_of_base(base, most);
  vec2 modifiers = kModifiers[table];
  shift = 0.0;
  for (int i = 0; i < kHalfTexels; ++i) {
    ivec2 place = place_in_half(flipped, second, i);
    vec3 away = color_at(place) - middle;
    float brighter = brightness(away);
    bool large = abs(brighter) > 0.5 * (modifiers.x + modifiers.y);
    float modifier = (brighter < 0.0 ? -1.0 : 1.0) * (large ? modifiers.y : modifiers.x);
    vec3 error = clamp(middle + modifier, 0.0, 255.0) - middle - away;
    result.error += dot(error, error);
    result.codes |= ((large ? 1u : 0u) | (brighter < 0.0 ? 0x10000u : 0u)) << position(place);
    shift += modifier / float(kHalfTexels);
  }
  return result;
}

Half best_half(bool flipped, int second, float most) {
  vec3 mean = vec3(0.0);
  for (int i = 0; i < kHalfTexels; ++i) mean += color_at(place_in_half(flipped, second, i)) / float(kHalfTexels);
  float darkest = 0.0, brightest = 0.0;  // from there
  for (int i = 0; i < kHalfTexels; ++i) {
    float brighter = brightness(color_at(place_in_half(flipped, second, i)) - mean);
    darkest = min(darkest, brighter);
    brightest = max(brightest, brighter);
  }
  Half best = Half(vec3(0.0), 0, 0u, 1e9);
  for (int table = 0; table < 8; ++table) {
    vec3 base = base_of_color(mean + 0.5 * (darkest + brightest), most);
    for (int i = 0; i < kRounds; ++i) {
      float shift;
      Half next = coded_half(flipped, second, base, most, table, shift);
      if (next.error < best.error) best = next;
      base = base_of_color(mean - shift, most);
      if (base == next.base) break;
    }
  }
  return best;
}

struct Colors {
  uvec2 bits;  // the first word has the higher ones
  float error;
};

uint packed_bits(vec3 values, ivec3 shifts) {
  uvec3 whole = uvec3(ivec3(values)) << shifts;
  return whole.x | whole.y | whole.z;
}

Colors coded_in_halves(bool flipped) {
  Half first = best_half(flipped, 0, kMostOfPair), second = best_half(flipped, 1, kMostOfPair);
  vec3 difference = second.base - first.base;
  bool near = all(greaterThanEqual(difference, vec3(-4.0))) && all(lessThanEqual(difference, vec3(3.0)));
  uint bases;
  if (near) {
    bases = packed_bits(first.base, ivec3(27, 19, 11)) | packed_bits(mod(difference, 8.0), ivec3(24, 16, 8)) | 2u;
  } else {
    first = best_half(flipped, 0, kMostOfTwo);
    second = best_half(flipped, 1, kMostOfTwo);
    bases = packed_bits(first.base, ivec3(28, 20, 12)) | packed_bits(second.base, ivec3(24, 16, 8));
  }
  uint tables = uint(first.table << 5 | second.table << 2);
  return Colors(uvec2(bases | tables | (flipped ? 1u : 0u), first.codes | second.codes), first.error + second.error);
}

const vec3 kMostOfPlane = vec3(63.0, 127.0, 63.0);

vec3 color_of_plane(vec3 bits) {
  ivec3 whole = ivec3(bits);
  return vec3((whole << ivec3(2, 1, 2)) | (whole >> ivec3(4, 6, 4)));
}

vec3 plane_of_color(vec3 color) {
  return floor(clamp(color, 0.0, 255.0) / 255.0 * kMostOfPlane + 0.5);
}

// A plane through three colours: at the first texel, and where a fifth column and a fifth row would be.
Colors coded_as_plane() {
  vec3 mean = vec3(0.0), right = vec3(0.0), down = vec3(0.0);
  for (int i = 0; i < kTexels; ++i) {
    vec2 from_middle = vec2(i % kSide, i / kSide) - 1.5;
    mean += colors[i] / float(kTexels);
    right += from_middle.x * colors[i] / 20.0;  // the sum of squares
    down += from_middle.y * colors[i] / 20.0;
  }
  vec3 origin = mean - 1.5 * (right + down);
  vec3 o = plane_of_color(origin), h = plane_of_color(origin + 4.0 * right), v = plane_of_color(origin + 4.0 * down);
  vec3 of_o = color_of_plane(o), of_h = color_of_plane(h), of_v = color_of_plane(v);
  float error = 0.0;
  for (int i = 0; i < kTexels; ++i) {
    vec3 color = floor((float(i % kSide) * (of_h - of_o) + float(i / kSide) * (of_v - of_o) + 4.0 * of_o + 2.0) / 4.0);
    vec3 away = clamp(color, 0.0, 255.0) - colors[i];
    error += dot(away, away);
  }
  uvec3 O = uvec3(o), H = uvec3(h), V = uvec3(v);
  uint bits = O.x << 25 | (O.y >> 6) << 24 | (O.y & 63u) << 17 | (O.z >> 5) << 16 | (O.z >> 3 & 3u) << 11 |
      (O.z & 7u) << 7 | (H.x >> 1) << 2 | 2u | (H.x & 1u);
  // Sets unused bits so that red and green, as a base and a difference, stay within their range, and blue leaves it.
  if ((bits >> 27 & 15u) < 4u && (bits >> 26 & 1u) == 1u) bits |= 1u << 31;
  if ((bits >> 19 & 15u) < 4u && (bits >> 18 & 1u) == 1u) bits |= 1u << 23;
  bits |= (bits >> 11 & 3u) + (bits >> 8 & 3u) < 4u ? 1u << 10 : 7u << 13;
  return Colors(uvec2(bits, H.y << 25 | H.z << 19 | V.x << 13 | V.y << 6 | V.z), error);
}

uvec2 color_block() {
  Colors best = coded_as_plane();
  for (int flipped = 0; flipped < 2; ++flipped) {
    Colors next = coded_in_halves(flipped == 1);
    if (next.error < best.error) best = next;
  }
  return best.bits;
}

// The values that are added to a base, times a multiplier.
const int kAlphaModifiers[128] = int[](
    -3, -6, -9, -15, 2, 5, 8, 14, -3, -7, -10, -13, 2, 6, 9, 12, -2, -5, -8, -13, 1, 4, 7, 12,
    -2, -4, -6, -13, 1, 3, 5, 12, -3, -6, -8, -12, 2, 5, 7, 11, -3, -7, -9, -11, 2, 6, 8, 10,
    -4, -7, -8, -11, 3, 6, 7, 10, -3, -5, -8, -11, 2, 4, 7, 10, -2, -6, -8, -10, 1, 5, 7, 9,
    -2, -5, -8, -10, 1, 4, 7, 9, -2, -4, -8, -10, 1, 3, 7, 9, -2, -5, -7, -10, 1, 4, 6, 9,
    -3, -4, -7, -10, 2, 3, 6, 9, -1, -2, -3, -10, 0, 1, 2, 9, -4, -6, -8, -9, 3, 5, 7, 8,
    -3, -5, -7, -9, 2, 4, 6, 8);

const int kFlatTable = 13;  // it can add nothing

struct Alphas {
  int base, multiplier, table;
  uvec2 codes;  // the first word has the higher ones
  float error;
};

// Returns the nearest value for each texel. Valid texels stay valid, invalid ones invalid. Stops early if the error is
// above `most`.
Alphas coded_alphas(int base, int multiplier, int table, float most) {
  Alphas result = Alphas(base, multiplier, table, uvec2(0u), 0.0);
  for (int i = 0; i < kTexels && result.error < most; ++i) {
    float least = 4.0 * kOtherMeaning;
    uint code = 0u;
    for (int j = 0; j < 8; ++j) {
      float error = alpha_error(clamp(base + multiplier * kAlphaModifiers[8 * table + j], 0, 255), alphas[i]);
      if (error < least) {
        least = error;
        code = uint(j);
      }
    }
    int bit = 45 - 3 * position(ivec2(i % kSide, i / kSide));
    if (bit >= 32) {
      result.codes.x |= code << (bit - 32);
    } else {
      result.codes.y |= code << bit;
      if (bit > 29) result.codes.x |= code >> (32 - bit);
    }
    result.error += least;
  }
  return result;
}

Alphas best_alphas() {
  int least = 255, most = 0;
  for (int i = 0; i < kTexels; ++i) {
    least = min(least, alphas[i]);
    most = max(most, alphas[i]);
  }
  if (least == most) return coded_alphas(least, 1, kFlatTable, 1.0);
  Alphas best = coded_alphas(128, 15, 0, 1e9);  // which has 0 and 255
  for (int table = 0; table < 16 && best.error > 0.0; ++table) {
    int low = kAlphaModifiers[8 * table + 3], high = kAlphaModifiers[8 * table + 7];
    int step = (most - least) / (high - low);
    for (int multiplier = max(step, 1); multiplier <= min(step + 1, 15); ++multiplier) {
      int base = clamp((least + most - multiplier * (low + high)) / 2, 0, 255);
      Alphas next = coded_alphas(base, multiplier, table, best.error);
      if (next.error < best.error) best = next;
    }
  }
  return best;
}

// In the block's format the highest byte of a word comes first.
uint swapped(uint word) {
  return word << 24 | (word & 0xFF00u) << 8 | (word >> 8 & 0xFF00u) | word >> 24;
}

void main() {
  read_texels();
  Alphas alpha = best_alphas();
  uint head = uint(alpha.base) << 24 | uint(alpha.multiplier) << 20 | uint(alpha.table) << 16;
  uvec2 color = color_block();
  block = uvec4(swapped(head | alpha.codes.x), swapped(alpha.codes.y), swapped(color.x), swapped(color.y));
}
