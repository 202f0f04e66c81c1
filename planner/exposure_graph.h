// SPDX-License-Identifier: GPL-3.0-or-later
// Exposure gains of all stored views at once, from the ratios measured between pairs of them.
//
// Matching each new view to the ones before it (Erat et al. 2019, section 3.3) adds up the error of every step, so that
// a long stream drifts and a loop does not close. Keeping the pairwise ratios and solving
//
//   min  sum_ij sqrt(n_ij) [h(ln g_i - ln g_j - r_ij) + e (ln g_i)^2 + e (ln g_j)^2]
//
//   h(x) = c^2 ln(1 + x^2 / c^2)   Cauchy's loss; c = 0.1, a sixth of a stop; minimised by four rounds of reweighting
//   r_ij, n_ij                     log_ratio or log_luminance, and points, of ExposureRatio
//   e                              0.001
//
// again whenever a view comes or goes spreads such errors over all of them, as panorama stitchers do (Brown and Lowe
// 2007, section 6). The small e keeps the mean of the logarithms near 0, so a stream as a whole grows neither brighter
// nor darker.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planner/median_colors.h"

namespace lumatlas {

// Slots that are not below the number given to the constructor are refused (std::invalid_argument).
class ExposureGraph {
 public:
  explicit ExposureGraph(std::uint32_t slots);

  // The ratios of a view to others, in place of those that it was given before. Each must be finite
  // (std::invalid_argument); otherwise nothing is changed.
  void set(std::uint32_t slot, std::span<const ExposureRatio> ratios);
  // Forgets every ratio that the slot is part of.
  void erase(std::uint32_t slot);

  // Gains by slot, positive; 1 for a slot without ratios. `white_balance`: each channel for itself, else all alike.
  [[nodiscard]] std::vector<glm::dvec3> solve(bool white_balance) const;

 private:
  std::vector<std::vector<ExposureRatio>> ratios_;  // by slot
};

}  // namespace lumatlas
