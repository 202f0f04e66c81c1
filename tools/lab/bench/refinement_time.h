// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how long refining a view takes, as the planner reports it, at any size of the photographs.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include "atlas/images/photograph.h"
#include "planner/planner.h"

namespace lumatlas {

struct RefinementTimes {
  std::size_t refined = 0;           // views
  double megapixels = 0;             // a photograph's, mean
  double median_ms = 0, p95_ms = 0;  // NaN if no view was refined
};

// Triangle filter, as wide as the larger of both pixels; the lens mask by its nearest pixel. Sizes >= 1.
[[nodiscard]] Photograph resampled(const Photograph& photograph, std::uint32_t width, std::uint32_t height);

// Offers evenly spaced views of the scene, kMostTimedViews at most, to a planner that has room for them all. With
// `megapixels` > 0, photographs and cameras are scaled to about that size, up or down. Throws InputError.
inline constexpr std::size_t kMostTimedViews = 60;
[[nodiscard]] RefinementTimes time_refinement(const std::filesystem::path& scene,
                                              const std::optional<std::filesystem::path>& mesh,
                                              const PlannerOptions& options, std::optional<double> megapixels);

}  // namespace lumatlas
