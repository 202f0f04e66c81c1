// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/mesh/mesh_coordinate_step.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <vector>

#include "mesh/finite.h"

namespace lumatlas {

namespace {

std::vector<glm::dvec3> sampled_positions(const TriangleSoup& soup) {
  constexpr std::size_t kSamples = 100'000;
  const std::size_t stride = soup.positions.size() / kSamples + 1;
  std::vector<glm::dvec3> samples;
  for (std::size_t i = 0; i < soup.positions.size(); i += stride) {
    if (is_finite(soup.positions[i])) samples.push_back(soup.positions[i]);
  }
  return samples;
}

// Returns the size, without signs, that 99 of 100 coordinates stay below on each axis. `positions` is not empty.
glm::dvec3 usual_size(const std::vector<glm::dvec3>& positions) {
  glm::dvec3 size(0);
  std::vector<double> values(positions.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < positions.size(); ++i) values[i] = std::abs(positions[i][axis]);
    const auto high = values.end() - 1 - static_cast<std::ptrdiff_t>(values.size() / 100);
    std::nth_element(values.begin(), high, values.end());
    size[axis] = *high;
  }
  return size;
}

// Returns the distance between neighbouring numbers of `digits` decimal digits near `size`, which is above 0.
double decimal_step(double size, int digits) {
  return std::pow(10, std::floor(std::log10(size)) - digits + 1);
}

// A number of 32 bits, or one that was written as text of 9 digits, which these need.
bool is_float(double number) {
  constexpr double kNineDigits = 5e-9;
  return std::abs(number - double{static_cast<float>(number)}) <= kNineDigits * std::abs(number);
}

bool has_digits(double number, int digits) {
  constexpr double kRounding = 1e-14;
  if (number == 0) return true;
  const double step = decimal_step(std::abs(number), digits);
  return std::abs(number - step * std::round(number / step)) <= kRounding * std::abs(number);
}

template <typename Holds>
bool all_coordinates(const std::vector<glm::dvec3>& positions, Holds holds) {
  return std::all_of(positions.begin(), positions.end(),
                     [&](const glm::dvec3& p) { return holds(p.x) && holds(p.y) && holds(p.z); });
}

double float_step(double size) {
  constexpr int kBits = 24;
  int exponent = 0;
  std::frexp(size, &exponent);  // size < 2^exponent
  return std::ldexp(1, exponent - kBits);
}

}  // namespace

double mesh_coordinate_step(const TriangleSoup& soup) {
  constexpr int kFewestDigits = 6, kMostDigits = 8;  // C++ streams write 6; 32-bit numbers have 8
  const std::vector<glm::dvec3> positions = sampled_positions(soup);
  if (positions.empty()) return 0;
  const glm::dvec3 sizes = usual_size(positions);
  const double size = std::max({sizes.x, sizes.y, sizes.z});
  if (!(size > 0)) return 0;
  for (int digits = kFewestDigits; digits <= kMostDigits; ++digits) {
    if (all_coordinates(positions, [&](double c) { return has_digits(c, digits); })) return decimal_step(size, digits);
  }
  return all_coordinates(positions, is_float) ? float_step(size) : 0;
}

}  // namespace lumatlas
