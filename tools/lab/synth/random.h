// SPDX-License-Identifier: GPL-3.0-or-later
// Random numbers of the synthetic scenes: functions of a seed and a place, so that no order of work changes them.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace lumatlas::synth {

// The finaliser of SplitMix64 (Steele, Lea, Flood 2014): a bijection in which every bit depends on every bit.
constexpr std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

constexpr std::uint64_t hashed(std::uint64_t seed) {
  return mixed(seed);
}
template <typename... Rest>
constexpr std::uint64_t hashed(std::uint64_t seed, std::uint64_t key, Rest... rest) {
  return hashed(mixed(seed) ^ key, rest...);
}

// A number in [0, 1), a multiple of 2^-24.
constexpr float unit_float(std::uint64_t bits) {
  return static_cast<float>(bits >> 40) * 0x1p-24F;
}

// A stream of numbers.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(mixed(seed)) {}
  std::uint64_t next() { return mixed(state_++); }
  float uniform() { return unit_float(next()); }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(((next() >> 32) * n) >> 32); }

 private:
  std::uint64_t state_;
};

// A draw of the standard normal distribution, cut off at 5.8 (Box, Muller 1958).
inline double gaussian(Random& random) {
  const double radius = std::sqrt(-2 * std::log(1 - static_cast<double>(random.uniform())));
  return radius * std::cos(2 * std::numbers::pi * random.uniform());
}

}  // namespace lumatlas::synth
