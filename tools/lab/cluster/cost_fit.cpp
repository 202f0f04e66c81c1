// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/cluster/cost_fit.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

namespace lumatlas {

namespace {

constexpr std::size_t kTerms = 3;  // per photograph, per face, per job
using Terms = std::array<double, kTerms>;

Terms row_of(const CostSample& sample) {
  return {sample.photographs / sample.cost, sample.faces / sample.cost, 1 / sample.cost};
}

// Solves for the terms in `used`, by Gauss-Jordan with pivots on the normal equations, whose columns are scaled to
// length 1. None: they cannot be told apart.
std::optional<Terms> solved(const std::vector<CostSample>& samples, unsigned used) {
  constexpr double kSingular = 1e-9;
  std::array<std::array<double, kTerms + 1>, kTerms> a{};
  Terms scale{};
  for (const CostSample& sample : samples) {
    const Terms row = row_of(sample);
    for (std::size_t i = 0; i < kTerms; ++i) scale[i] += row[i] * row[i];
  }
  for (double& s : scale) s = std::sqrt(s);
  for (const CostSample& sample : samples) {
    const Terms row = row_of(sample);
    for (std::size_t i = 0; i < kTerms; ++i) {
      if (scale[i] == 0) continue;
      for (std::size_t j = 0; j < kTerms; ++j) {
        if (scale[j] > 0) a[i][j] += row[i] * row[j] / (scale[i] * scale[j]);
      }
      a[i][kTerms] += row[i] / scale[i];
    }
  }
  Terms terms{};
  std::array<bool, kTerms> is_used{};
  for (std::size_t i = 0; i < kTerms; ++i) is_used[i] = (used >> i & 1U) != 0;
  for (std::size_t i = 0; i < kTerms; ++i) {
    if (!is_used[i]) continue;
    if (std::abs(a[i][i]) < kSingular) return std::nullopt;
    for (std::size_t k = 0; k < kTerms; ++k) {
      if (k == i || !is_used[k]) continue;
      const double factor = a[k][i] / a[i][i];
      for (std::size_t j = 0; j <= kTerms; ++j) a[k][j] -= factor * a[i][j];
    }
  }
  for (std::size_t i = 0; i < kTerms; ++i) {
    if (is_used[i]) terms[i] = a[i][kTerms] / a[i][i] / scale[i];
  }
  return terms;
}

double squared_error(const std::vector<CostSample>& samples, const Terms& terms) {
  double sum = 0;
  for (const CostSample& sample : samples) {
    const Terms row = row_of(sample);
    double error = -1;
    for (std::size_t i = 0; i < kTerms; ++i) error += terms[i] * row[i];
    sum += error * error;
  }
  return sum;
}

}  // namespace

CostFit fitted_cost(const std::vector<CostSample>& given) {
  std::vector<CostSample> samples;
  for (const CostSample& sample : given) {
    if (sample.cost > 0) samples.push_back(sample);
  }
  constexpr double kBetter = 1e-9;  // by which more terms must be better
  Terms best{};
  double least = std::numeric_limits<double>::infinity();
  // Fewer terms come before more of them.
  for (const unsigned used : {1U, 2U, 4U, 3U, 5U, 6U, 7U}) {
    if (samples.empty()) break;
    const std::optional<Terms> terms = solved(samples, used);
    if (!terms || (*terms)[0] < 0 || (*terms)[1] < 0 || (*terms)[2] < 0) continue;
    const double error = squared_error(samples, *terms);
    if (error >= least - kBetter) continue;
    least = error;
    best = *terms;
  }
  return {best[2], best[0], best[1]};
}

}  // namespace lumatlas
