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
// nor darker. The minimum is looked for by reweighting least squares a fixed number of times. Each of these linear
// systems is solved by conjugate gradients that begin at its last solution. So a view that comes or goes costs a few
// passes over all ratios: time grows with their number, not with the cube of the number of views.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planner/refinement/median_colors.h"

namespace lumatlas {

// Slots that are not below the number given to the constructor are refused (std::invalid_argument).
class ExposureGraph {
 public:
  explicit ExposureGraph(std::uint32_t slots);

  // Replaces the ratios of a view to others. Each must be finite (std::invalid_argument); otherwise nothing is changed.
  void set(ViewSlot slot, std::span<const ExposureRatio> ratios);
  // Forgets every ratio that the view slot is part of.
  void erase(ViewSlot slot);

  // Gains by view slot, positive; 1 for a slot without ratios. `white_balance`: each channel for itself, else all
  // alike. Their logarithms are those of the exact solution of the last linear system to 1e-6, and mostly to far less.
  [[nodiscard]] std::vector<glm::dvec3> solve(bool white_balance);

  // Returns how often all calls of solve() have read a ratio, which their time grows with.
  [[nodiscard]] std::uint64_t looks() const { return looks_; }

 private:
  static constexpr std::size_t kSystems = 5;  // least squares without weights, then reweighted
  // One channel's last solution of each system, ln gains by view slot; empty at first.
  using Solutions = std::array<std::vector<double>, kSystems>;

  [[nodiscard]] const std::vector<double>& log_gains(bool white_balance, int channel);

  std::vector<std::vector<ExposureRatio>> ratios_;  // one per view slot
  std::array<Solutions, 4> solutions_;              // one per channel, and luminance
  std::uint64_t looks_ = 0;
};

}  // namespace lumatlas
