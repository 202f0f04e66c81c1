// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/tiles/bc7_block.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace lumatlas {

namespace {

using Values = std::array<float, 4>;  // one per channel
using Texel = std::array<std::uint8_t, 4>;
using Codes = std::array<std::uint8_t, kBc7BlockTexels>;

constexpr std::uint64_t kImpossible = std::numeric_limits<std::uint64_t>::max();

// Weights of the second end of a ramp, in 64ths, for codes of 2, 3 and 4 bits.
constexpr std::array<std::uint8_t, 4> kWeights2{0, 21, 43, 64};
constexpr std::array<std::uint8_t, 8> kWeights3{0, 9, 18, 27, 37, 46, 55, 64};
constexpr std::array<std::uint8_t, 16> kWeights4{0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64};
constexpr float kWhole = 64;

std::span<const std::uint8_t> weights_of(int code_bits) {
  if (code_bits == 2) return kWeights2;
  if (code_bits == 3) return kWeights3;
  return kWeights4;
}

std::uint8_t between(std::uint32_t first, std::uint32_t second, std::uint32_t weight) {
  return static_cast<std::uint8_t>(((64 - weight) * first + weight * second + 32) >> 6);
}

// An end of a ramp in one channel: what is in the block, and what it stands for.
std::uint8_t expanded(std::uint32_t stored, int bits) {
  const std::uint32_t high = stored << (8 - bits);
  return static_cast<std::uint8_t>(high | high >> bits);
}

// Rounds without std::round(), which is a function call unless the compiler may use SSE4.1.
std::uint32_t rounded_within(float value, float most) {
  return static_cast<std::uint32_t>(std::clamp(value, 0.0F, most) + 0.5F);
}

std::uint32_t nearest_stored(float value, int bits) {
  const auto most = static_cast<float>((1 << bits) - 1);
  return rounded_within(value * most / 255, most);
}

// The storage of a ramp.
struct RampFormat {
  std::size_t first, channels;  // those of colour and alpha that the ramp has
  int bits;                     // for an end in one channel
  bool shared;                  // a bit more, the lowest, which is the same in all channels
  int code_bits;                // for a texel's step
};
constexpr RampFormat kAllOfMode6{0, 4, 7, true, 4};
constexpr RampFormat kColorOfMode4{0, 3, 5, false, 2};
constexpr RampFormat kAlphaOfMode4{3, 1, 6, false, 3};

struct End {
  std::array<std::uint32_t, 4> stored{};
  std::uint32_t shared = 0;
  Texel value{};
};

struct Ramp {
  std::array<End, 2> ends;
  Codes codes{};
  std::uint64_t error = kImpossible;
};

End stored_end(const Values& wanted, const RampFormat& format, std::uint32_t shared) {
  End end;
  end.shared = shared;
  for (std::size_t channel = format.first; channel < format.first + format.channels; ++channel) {
    if (format.shared) {
      const float most = static_cast<float>((1 << format.bits) - 1);
      end.stored[channel] = rounded_within((wanted[channel] - static_cast<float>(shared)) / 2, most);
      end.value[channel] = static_cast<std::uint8_t>(2 * end.stored[channel] + shared);
    } else {
      end.stored[channel] = nearest_stored(wanted[channel], format.bits);
      end.value[channel] = expanded(end.stored[channel], format.bits);
    }
  }
  return end;
}

float squared_distance(const End& end, const Values& wanted, const RampFormat& format) {
  float sum = 0;
  for (std::size_t channel = format.first; channel < format.first + format.channels; ++channel) {
    const float away = static_cast<float>(end.value[channel]) - wanted[channel];
    sum += away * away;
  }
  return sum;
}

// The nearer one with a shared bit of 0 or 1; with one alpha for all texels, the bit that leaves alpha as it is.
End nearest_end(const Values& wanted, const RampFormat& format, std::optional<std::uint32_t> one_alpha) {
  if (!format.shared) return stored_end(wanted, format, 0);
  if (one_alpha) return stored_end(wanted, format, *one_alpha & 1);
  const End even = stored_end(wanted, format, 0), odd = stored_end(wanted, format, 1);
  return squared_distance(odd, wanted, format) < squared_distance(even, wanted, format) ? odd : even;
}

// Gives each texel the step of the ramp that is nearest to it, apart from steps that are not quite even, and sets the
// error of that.
void give_codes(const BlockTexels& texels, const RampFormat& format, Ramp& ramp) {
  const std::span<const std::uint8_t> weights = weights_of(format.code_bits);
  const std::size_t end = format.first + format.channels;
  std::array<Texel, 16> steps{};
  Values along{};
  float length = 0;
  for (std::size_t channel = format.first; channel < end; ++channel) {
    const std::uint8_t first = ramp.ends[0].value[channel], second = ramp.ends[1].value[channel];
    for (std::size_t code = 0; code < weights.size(); ++code) {
      steps[code][channel] = between(first, second, weights[code]);
    }
    along[channel] = static_cast<float>(second) - static_cast<float>(first);
    length += along[channel] * along[channel];
  }
  const float most = static_cast<float>(weights.size() - 1);
  const float scale = length > 0 ? most / length : 0;
  ramp.error = 0;
  for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
    float at = 0;
    for (std::size_t channel = format.first; channel < end; ++channel) {
      at += (static_cast<float>(texels[i][channel]) - static_cast<float>(ramp.ends[0].value[channel])) * along[channel];
    }
    const std::size_t code = rounded_within(at * scale, most);
    ramp.codes[i] = static_cast<std::uint8_t>(code);
    for (std::size_t channel = format.first; channel < end; ++channel) {
      const int away = int{steps[code][channel]} - int{texels[i][channel]};
      ramp.error += static_cast<std::uint64_t>(away * away);
      if (channel == 3 && (steps[code][3] == 0) != (texels[i][3] == 0)) {
        ramp.error = kImpossible;
        return;
      }
    }
  }
}

// The channels of a ramp: each texel less the mean of all, and the farthest texel from it.
struct Spread {
  Values mean{};
  std::array<Values, kBc7BlockTexels> from_mean{};
  std::size_t farthest = 0;
};

Spread spread_of(const BlockTexels& texels, const RampFormat& format) {
  Spread spread;
  const std::size_t end = format.first + format.channels;
  for (const Texel& texel : texels) {
    for (std::size_t a = format.first; a < end; ++a) spread.mean[a] += static_cast<float>(texel[a]) / kBc7BlockTexels;
  }
  float most = 0;
  for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
    float square = 0;
    for (std::size_t a = format.first; a < end; ++a) {
      spread.from_mean[i][a] = static_cast<float>(texels[i][a]) - spread.mean[a];
      square += spread.from_mean[i][a] * spread.from_mean[i][a];
    }
    if (square <= most) continue;
    most = square;
    spread.farthest = i;
  }
  return spread;
}

// Returns the direction in which the channels vary most: by the power method, which finds it unless it begins at right
// angles to it. That is why it begins at a texel.
Values principal_direction(const Spread& spread, const RampFormat& format) {
  constexpr int kIterations = 6;
  const std::size_t first = format.first, end = first + format.channels;
  std::array<Values, 4> covariance{};
  for (const Values& texel : spread.from_mean) {
    for (std::size_t a = first; a < end; ++a) {
      for (std::size_t b = first; b < end; ++b) covariance[a][b] += texel[a] * texel[b];
    }
  }
  Values direction = spread.from_mean[spread.farthest];
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Values next{};
    float most = 0;
    for (std::size_t a = first; a < end; ++a) {
      for (std::size_t b = first; b < end; ++b) next[a] += covariance[a][b] * direction[b];
      most = std::max(most, std::abs(next[a]));
    }
    if (most == 0) break;
    for (std::size_t a = first; a < end; ++a) direction[a] = next[a] / most;
  }
  return direction;
}

// Returns the ends of the shortest piece of the line through the mean in that direction that has all texels beside it.
std::array<Values, 2> ends_of(const Spread& spread, const Values& direction) {
  float length = 0, least = 0, most = 0;
  for (const float part : direction) length += part * part;
  if (length > 0) {
    least = std::numeric_limits<float>::max();
    most = -least;
    for (const Values& texel : spread.from_mean) {
      float at = 0;
      for (std::size_t a = 0; a < 4; ++a) at += texel[a] * direction[a];
      least = std::min(least, at / length);
      most = std::max(most, at / length);
    }
  }
  std::array<Values, 2> ends{spread.mean, spread.mean};
  for (std::size_t a = 0; a < 4; ++a) {
    ends[0][a] += least * direction[a];
    ends[1][a] += most * direction[a];
  }
  return ends;
}

// The ends that make the squared error least, for the codes that the texels have; false where these say nothing.
bool fit_ends(const BlockTexels& texels, const RampFormat& format, const Codes& codes, std::array<Values, 2>& ends) {
  const std::span<const std::uint8_t> weights = weights_of(format.code_bits);
  float of_first = 0, of_both = 0, of_second = 0;
  std::array<Values, 2> sums{};
  for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
    const float second = static_cast<float>(weights[codes[i]]) / kWhole, first = 1 - second;
    of_first += first * first;
    of_both += first * second;
    of_second += second * second;
    for (std::size_t a = format.first; a < format.first + format.channels; ++a) {
      sums[0][a] += first * static_cast<float>(texels[i][a]);
      sums[1][a] += second * static_cast<float>(texels[i][a]);
    }
  }
  const float determinant = of_first * of_second - of_both * of_both;
  if (determinant < 1e-3F) return false;
  for (std::size_t a = format.first; a < format.first + format.channels; ++a) {
    ends[0][a] = (of_second * sums[0][a] - of_both * sums[1][a]) / determinant;
    ends[1][a] = (of_first * sums[1][a] - of_both * sums[0][a]) / determinant;
  }
  return true;
}

Ramp best_ramp(const BlockTexels& texels, const RampFormat& format, std::optional<std::uint32_t> one_alpha = {}) {
  constexpr int kFits = 1;
  const Spread spread = spread_of(texels, format);
  std::array<Values, 2> wanted = ends_of(spread, principal_direction(spread, format));
  Ramp best;
  for (int fits = 0; fits <= kFits; ++fits) {
    Ramp ramp{{nearest_end(wanted[0], format, one_alpha), nearest_end(wanted[1], format, one_alpha)}, {}, 0};
    give_codes(texels, format, ramp);
    if (ramp.error >= best.error) break;
    best = ramp;
    if (best.error == 0 || !fit_ends(texels, format, best.codes, wanted)) break;
  }
  return best;
}

// A ramp from the least to the greatest alpha. What is not 0 gets no 0, not even the nearest.
Ramp alpha_ramp(const BlockTexels& texels, const RampFormat& format) {
  const auto by_alpha = [](const Texel& a, const Texel& b) { return a[3] < b[3]; };
  const auto [least, most] = std::minmax_element(texels.begin(), texels.end(), by_alpha);
  Ramp ramp;
  for (std::size_t e = 0; e < 2; ++e) {
    const std::uint8_t alpha = e == 0 ? (*least)[3] : (*most)[3];
    End& end = ramp.ends[e];
    end.stored[3] = nearest_stored(alpha, format.bits);
    if (alpha != 0) end.stored[3] = std::max(end.stored[3], 1U);
    end.value[3] = expanded(end.stored[3], format.bits);
  }
  const std::span<const std::uint8_t> weights = weights_of(format.code_bits);
  ramp.error = 0;
  for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
    std::uint64_t least_error = kImpossible;
    for (std::size_t code = 0; code < weights.size(); ++code) {
      const std::uint8_t step = between(ramp.ends[0].value[3], ramp.ends[1].value[3], weights[code]);
      if ((step == 0) != (texels[i][3] == 0)) continue;
      const int away = int{step} - int{texels[i][3]};
      const auto error = static_cast<std::uint64_t>(away * away);
      if (error >= least_error) continue;
      least_error = error;
      ramp.codes[i] = static_cast<std::uint8_t>(code);
    }
    ramp.error += least_error;
  }
  return ramp;
}

// The code of the first texel is a bit shorter than the others: its highest bit is 0.
void begin_with_low_code(Ramp& ramp, int code_bits) {
  if (ramp.codes[0] >> (code_bits - 1) == 0) return;
  std::swap(ramp.ends[0], ramp.ends[1]);
  for (std::uint8_t& code : ramp.codes) code = static_cast<std::uint8_t>((1 << code_bits) - 1 - code);
}

// Bits from the lowest of the first byte on.
class BitWriter {
 public:
  void put(std::uint32_t value, int bits) {
    for (int bit = 0; bit < bits; ++bit, ++at_) {
      block_[at_ / 8] |= static_cast<std::uint8_t>((value >> bit & 1) << (at_ % 8));
    }
  }
  void put_codes(const Codes& codes, int code_bits) {
    for (std::size_t i = 0; i < codes.size(); ++i) put(codes[i], i == 0 ? code_bits - 1 : code_bits);
  }
  [[nodiscard]] const Bc7Block& block() const { return block_; }

 private:
  Bc7Block block_{};
  std::size_t at_ = 0;
};

class BitReader {
 public:
  explicit BitReader(std::span<const std::uint8_t, kBc7BlockBytes> block) : block_(block) {}
  std::uint32_t take(int bits) {
    std::uint32_t value = 0;
    for (int bit = 0; bit < bits; ++bit, ++at_) value |= (block_[at_ / 8] >> (at_ % 8) & 1U) << bit;
    return value;
  }
  Codes take_codes(int code_bits) {
    Codes codes{};
    for (std::size_t i = 0; i < codes.size(); ++i) {
      codes[i] = static_cast<std::uint8_t>(take(i == 0 ? code_bits - 1 : code_bits));
    }
    return codes;
  }

 private:
  std::span<const std::uint8_t, kBc7BlockBytes> block_;
  std::size_t at_ = 0;
};

Bc7Block block_of_mode_6(Ramp ramp) {
  begin_with_low_code(ramp, kAllOfMode6.code_bits);
  BitWriter bits;
  bits.put(1U << 6, 7);
  for (std::size_t channel = 0; channel < 4; ++channel) {
    for (const End& end : ramp.ends) bits.put(end.stored[channel], kAllOfMode6.bits);
  }
  for (const End& end : ramp.ends) bits.put(end.shared, 1);
  bits.put_codes(ramp.codes, kAllOfMode6.code_bits);
  return bits.block();
}

Bc7Block block_of_mode_4(Ramp color, Ramp alpha) {
  begin_with_low_code(color, kColorOfMode4.code_bits);
  begin_with_low_code(alpha, kAlphaOfMode4.code_bits);
  BitWriter bits;
  bits.put(1U << 4, 5);
  bits.put(0, 3);  // no channel changes places with alpha, nor do the lengths of codes
  for (std::size_t channel = 0; channel < 3; ++channel) {
    for (const End& end : color.ends) bits.put(end.stored[channel], kColorOfMode4.bits);
  }
  for (const End& end : alpha.ends) bits.put(end.stored[3], kAlphaOfMode4.bits);
  bits.put_codes(color.codes, kColorOfMode4.code_bits);
  bits.put_codes(alpha.codes, kAlphaOfMode4.code_bits);
  return bits.block();
}

BlockTexels texels_of_mode_6(BitReader bits) {
  std::array<Texel, 2> ends{};
  for (std::size_t channel = 0; channel < 4; ++channel) {
    for (Texel& end : ends) end[channel] = static_cast<std::uint8_t>(bits.take(kAllOfMode6.bits) << 1);
  }
  for (Texel& end : ends) {
    const std::uint32_t shared = bits.take(1);
    for (std::uint8_t& value : end) value = static_cast<std::uint8_t>(value | shared);
  }
  const Codes codes = bits.take_codes(kAllOfMode6.code_bits);
  BlockTexels texels{};
  for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
    for (std::size_t channel = 0; channel < 4; ++channel) {
      texels[i][channel] = between(ends[0][channel], ends[1][channel], kWeights4[codes[i]]);
    }
  }
  return texels;
}

BlockTexels texels_of_mode_4(BitReader bits) {
  if (bits.take(3) != 0) throw std::invalid_argument("bc7 block: it is of mode 4 and changes channels, must not");
  std::array<Texel, 2> ends{};
  for (std::size_t channel = 0; channel < 4; ++channel) {
    const int stored = channel < 3 ? kColorOfMode4.bits : kAlphaOfMode4.bits;
    for (Texel& end : ends) end[channel] = expanded(bits.take(stored), stored);
  }
  const Codes colors = bits.take_codes(kColorOfMode4.code_bits);
  const Codes alphas = bits.take_codes(kAlphaOfMode4.code_bits);
  BlockTexels texels{};
  for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
    for (std::size_t channel = 0; channel < 4; ++channel) {
      const std::uint8_t weight = channel < 3 ? kWeights2[colors[i]] : kWeights3[alphas[i]];
      texels[i][channel] = between(ends[0][channel], ends[1][channel], weight);
    }
  }
  return texels;
}

}  // namespace

Bc7Block bc7_block(const BlockTexels& texels) {
  const std::uint8_t alpha = texels[0][3];
  const bool is_one = std::all_of(texels.begin(), texels.end(), [&](const Texel& texel) { return texel[3] == alpha; });
  if (is_one) return block_of_mode_6(best_ramp(texels, kAllOfMode6, alpha));
  const Ramp all = best_ramp(texels, kAllOfMode6);
  const Ramp color = best_ramp(texels, kColorOfMode4), apart = alpha_ramp(texels, kAlphaOfMode4);
  return all.error <= color.error + apart.error ? block_of_mode_6(all) : block_of_mode_4(color, apart);
}

BlockTexels texels_of(std::span<const std::uint8_t, kBc7BlockBytes> block) {
  const int mode = std::countr_zero(block[0]);  // 8: none
  BitReader bits(block);
  if (mode != 4 && mode != 6) {
    throw std::invalid_argument("bc7 block: its mode is " + std::to_string(mode) + ", must be 4 or 6");
  }
  (void)bits.take(mode + 1);
  return mode == 6 ? texels_of_mode_6(bits) : texels_of_mode_4(bits);
}

}  // namespace lumatlas
