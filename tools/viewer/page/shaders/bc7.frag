#version 300 es
// Compresses a block of 4 x 4 texels of a stored photograph to BC7, for a texture of sRGB, in two of its eight modes.
// Mode 6 has a ramp of 16 steps for colour and alpha together. Mode 4, for blocks in which they change apart, has one
// of 4 steps for colour and one of 8 for alpha. Counterpart of atlas/tiles/bc7_block.cpp. Source: the Khronos Data
// Format Specification, section "BPTC Compressed Texture Image Formats".
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

#include "block_texels.glsl"

layout(location = 0) out uvec4 block;

const int kPowerSteps = 6;  // steps to find the direction in which the texels vary most
const int kNoAlpha = -1;    // that all texels have

// The form in which a ramp is stored.
struct RampFormat {
  vec4 channels;  // 1: it has that channel of colour and alpha
  int bits;       // an end's in one channel
  bool is_shared; // a bit more, the lowest, which is the same in all channels
  int most_code;  // a texel's
};
const RampFormat kAllOfMode6 = RampFormat(vec4(1.0), 7, true, 15);
const RampFormat kColorOfMode4 = RampFormat(vec4(1.0, 1.0, 1.0, 0.0), 5, false, 3);
const RampFormat kAlphaOfMode4 = RampFormat(vec4(0.0, 0.0, 0.0, 1.0), 6, false, 7);

struct End {
  vec4 stored;  // whole numbers
  float shared_bit;
  vec4 value;  // that they stand for
};

struct Ramp {
  End first, second;
  uvec2 codes;  // 4 bits a texel
  float error;
};

vec4 texel_at(int i) {
  return vec4(colors[i], float(alphas[i]));
}

int code_of(uvec2 codes, int i) {
  return int((i < 8 ? codes.x >> (4 * i) : codes.y >> (4 * i - 32)) & 15u);
}

void add_code(inout uvec2 codes, int i, int code) {
  if (i < 8) {
    codes.x |= uint(code) << (4 * i);
  } else {
    codes.y |= uint(code) << (4 * i - 32);
  }
}

// Returns the weight of the second end, in 64ths.
float weight_of(int code, int most_code) {
  return float((64 * code + most_code / 2) / most_code);
}

vec4 step_at(Ramp ramp, int code, int most_code) {
  float weight = weight_of(code, most_code);
  return floor(((64.0 - weight) * ramp.first.value + weight * ramp.second.value + 32.0) / 64.0);
}

vec4 expanded(vec4 stored, int bits) {
  ivec4 high = ivec4(stored) << (8 - bits);
  return vec4(high | high >> bits);
}

End stored_end(vec4 wanted, RampFormat format, float shared_bit) {
  float most = float((1 << format.bits) - 1);
  if (format.is_shared) {
    vec4 stored = floor(clamp(0.5 * (wanted - shared_bit), 0.0, most) + 0.5);
    return End(stored, shared_bit, 2.0 * stored + shared_bit);
  }
  vec4 stored = floor(clamp(wanted * most / 255.0, 0.0, most) + 0.5);
  return End(stored, 0.0, expanded(stored, format.bits));
}

// The nearer one with a shared bit of 0 or 1; with one alpha for all texels, the bit that leaves alpha as it is.
End nearest_end(vec4 wanted, RampFormat format, int one_alpha) {
  if (one_alpha != kNoAlpha) return stored_end(wanted, format, float(one_alpha & 1));
  End even = stored_end(wanted, format, 0.0);
  if (!format.is_shared) return even;
  End odd = stored_end(wanted, format, 1.0);
  vec4 to_even = even.value - wanted, to_odd = odd.value - wanted;
  if (dot(to_odd, to_odd) < dot(to_even, to_even)) return odd;
  return even;
}

// Gives each texel the step of the ramp that is nearest to it, as if steps were even, which they are not quite.
Ramp coded(End first, End second, RampFormat format) {
  Ramp ramp = Ramp(first, second, uvec2(0u), 0.0);
  vec4 along = format.channels * (second.value - first.value);
  float most = float(format.most_code);
  float scale = most / max(dot(along, along), 1e-6);
  for (int i = 0; i < kTexels; ++i) {
    vec4 texel = texel_at(i);
    int code = int(clamp(scale * dot(texel - first.value, along), 0.0, most) + 0.5);
    add_code(ramp.codes, i, code);
    vec4 step = step_at(ramp, code, format.most_code);
    vec4 away = format.channels * (step - texel);
    ramp.error += dot(away, away);
    if (format.channels.a != 0.0 && (step.a == 0.0) != (texel.a == 0.0)) ramp.error += kOtherMeaning;
  }
  return ramp;
}

// Two ends of a line through the mean in the direction in which the channels vary most: of the least piece that has all
// texels beside it. The power method begins at the texel farthest from the mean, for at right angles to the direction
// it would not find it.
void find_ends(RampFormat format, out vec4 first, out vec4 second) {
  vec4 mean = vec4(0.0);
  for (int i = 0; i < kTexels; ++i) mean += format.channels * texel_at(i) / float(kTexels);
  mat4 covariance = mat4(0.0);
  vec4 direction = vec4(0.0);
  for (int i = 0; i < kTexels; ++i) {
    vec4 from_mean = format.channels * texel_at(i) - mean;
    covariance += outerProduct(from_mean, from_mean);
    if (dot(from_mean, from_mean) > dot(direction, direction)) direction = from_mean;
  }
  for (int i = 0; i < kPowerSteps; ++i) {
    vec4 next = covariance * direction;
    vec4 sizes = abs(next);
    float most = max(max(sizes.x, sizes.y), max(sizes.z, sizes.w));
    if (most == 0.0) break;
    direction = next / most;
  }
  float square = dot(direction, direction), least = 0.0, most = 0.0;
  for (int i = 0; i < kTexels && square > 0.0; ++i) {
    float at = dot(format.channels * texel_at(i) - mean, direction) / square;
    least = min(least, at);
    most = max(most, at);
  }
  first = mean + least * direction;
  second = mean + most * direction;
}

// The ends that make the squared error least for the codes that the texels have; false where these say nothing.
bool fit_ends(uvec2 codes, RampFormat format, out vec4 first, out vec4 second) {
  vec3 sums = vec3(0.0);  // sums of the shares' squares and products
  vec4 by_first = vec4(0.0), by_second = vec4(0.0);
  for (int i = 0; i < kTexels; ++i) {
    float share = weight_of(code_of(codes, i), format.most_code) / 64.0;
    sums += vec3((1.0 - share) * (1.0 - share), share * share, share * (1.0 - share));
    by_first += (1.0 - share) * texel_at(i);
    by_second += share * texel_at(i);
  }
  float determinant = sums.x * sums.y - sums.z * sums.z;
  first = (sums.y * by_first - sums.z * by_second) / determinant;
  second = (sums.x * by_second - sums.z * by_first) / determinant;
  return determinant >= 1e-3;
}

Ramp best_ramp(RampFormat format, int one_alpha) {
  vec4 first, second;
  find_ends(format, first, second);
  Ramp best = coded(nearest_end(first, format, one_alpha), nearest_end(second, format, one_alpha), format);
  if (best.error > 0.0 && fit_ends(best.codes, format, first, second)) {
    Ramp fitted = coded(nearest_end(first, format, one_alpha), nearest_end(second, format, one_alpha), format);
    if (fitted.error < best.error) best = fitted;
  }
  return best;
}

End alpha_end(int alpha) {
  End end = stored_end(vec4(float(alpha)), kAlphaOfMode4, 0.0);
  if (alpha != 0) end.stored = max(end.stored, 1.0);
  end.value = expanded(end.stored, kAlphaOfMode4.bits);
  return end;
}

// From the least to the greatest alpha. What is valid stays valid, and what is not, not.
Ramp alpha_ramp(int least_alpha, int most_alpha) {
  Ramp ramp = Ramp(alpha_end(least_alpha), alpha_end(most_alpha), uvec2(0u), 0.0);
  for (int i = 0; i < kTexels; ++i) {
    float least = 4.0 * kOtherMeaning;
    int nearest = 0;
    for (int code = 0; code <= kAlphaOfMode4.most_code; ++code) {
      float error = alpha_error(int(step_at(ramp, code, kAlphaOfMode4.most_code).a), alphas[i]);
      if (error >= least) continue;
      least = error;
      nearest = code;
    }
    add_code(ramp.codes, i, nearest);
    ramp.error += least;
  }
  return ramp;
}

// The code of the first texel is a bit shorter than the others: its highest bit is 0.
void begin_with_low_code(inout Ramp ramp, int most_code) {
  if (2 * code_of(ramp.codes, 0) < most_code) return;
  End first = ramp.first;
  ramp.first = ramp.second;
  ramp.second = first;
  uvec2 codes = ramp.codes;
  ramp.codes = uvec2(0u);
  for (int i = 0; i < kTexels; ++i) add_code(ramp.codes, i, most_code - code_of(codes, i));
}

uvec4 words = uvec4(0u);  // the block
int written = 0;          // bits

void put(int value, int bits) {
  int word = written / 32, shift = written % 32;
  words[word] |= uint(value) << shift;
  if (shift + bits > 32) words[word + 1] |= uint(value) >> (32 - shift);
  written += bits;
}

void put_codes(uvec2 codes, int bits) {
  for (int i = 0; i < kTexels; ++i) put(code_of(codes, i), i == 0 ? bits - 1 : bits);
}

void write_mode_6(Ramp ramp) {
  begin_with_low_code(ramp, kAllOfMode6.most_code);
  put(1 << 6, 7);
  for (int channel = 0; channel < 4; ++channel) {
    put(int(ramp.first.stored[channel]), kAllOfMode6.bits);
    put(int(ramp.second.stored[channel]), kAllOfMode6.bits);
  }
  put(int(ramp.first.shared_bit), 1);
  put(int(ramp.second.shared_bit), 1);
  put_codes(ramp.codes, 4);
}

void write_mode_4(Ramp color, Ramp alpha) {
  begin_with_low_code(color, kColorOfMode4.most_code);
  begin_with_low_code(alpha, kAlphaOfMode4.most_code);
  put(1 << 4, 5);
  put(0, 3);  // no channel changes places with alpha, nor do the lengths of codes
  for (int channel = 0; channel < 3; ++channel) {
    put(int(color.first.stored[channel]), kColorOfMode4.bits);
    put(int(color.second.stored[channel]), kColorOfMode4.bits);
  }
  put(int(alpha.first.stored.a), kAlphaOfMode4.bits);
  put(int(alpha.second.stored.a), kAlphaOfMode4.bits);
  put_codes(color.codes, 2);
  put_codes(alpha.codes, 3);
}

void main() {
  read_texels();
  int least = 255, most = 0;
  for (int i = 0; i < kTexels; ++i) {
    least = min(least, alphas[i]);
    most = max(most, alphas[i]);
  }
  Ramp all = best_ramp(kAllOfMode6, least == most ? least : kNoAlpha);
  bool apart = false;
  if (least != most) {
    Ramp color = best_ramp(kColorOfMode4, kNoAlpha), alpha = alpha_ramp(least, most);
    apart = all.error > color.error + alpha.error;
    if (apart) write_mode_4(color, alpha);
  }
  if (!apart) write_mode_6(all);
  block = words;
}
