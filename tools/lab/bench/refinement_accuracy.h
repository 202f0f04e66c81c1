// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how much of known errors remains after refinement: builds a disturbed synthetic scene, and compares the
// stored views with the truth that comes with the scene.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/pipeline/build_model.h"

namespace lumatlas {

// Root mean square distance, pixels, between where the surface is and where it should be in the pictures: with the
// given pose, with the stored one, and with that after the stored views' common motion has been undone (see
// pose_error.h). Infinite where part of the surface is behind the camera.
struct PoseError {
  double given_px = 0;
  double stored_px = 0;
  double relative_px = 0;
};

struct ViewAccuracy {
  std::string name;
  bool wrong = false;  // its given pose is plainly wrong
  Decision decision = Decision::rejected;
  std::optional<PoseError> pose;  // none: it was not stored
  glm::dvec3 given_gain{1.0};     // factor by which its linear light is off before refinement
  glm::dvec3 stored_gain{1.0};    // the same after refinement; perfect if all views have the same
  std::optional<Refinement> refinement;
};

// Pixels of the stored views.
struct MaskAccuracy {
  std::uint64_t hidden = 0;      // hidden by a passer-by, in truth
  std::uint64_t distrusted = 0;  // masked by the trust masks
  std::uint64_t both = 0;
};

struct RefinementAccuracy {
  std::vector<ViewAccuracy> views;  // in the order of the stream
  MaskAccuracy masks;
  double refine_ms = 0;  // median of the refined views; NaN if there are none
};

// A wrong view that is kept counts as found if its pose is off by less than this, pixels.
inline constexpr double kFound_px = 1;

// Options that make the most of a scene's views: the store has room for all of them, and whatever helps is kept.
[[nodiscard]] BuildOptions options_to_keep_all();

// `scene` is a folder of write_synthetic_scene() with disturbances. Throws InputError.
[[nodiscard]] RefinementAccuracy measure_refinement(const std::filesystem::path& scene, const BuildOptions& options);

// The shares, medians and deviations, and an entry for each view.
[[nodiscard]] nlohmann::json json_accuracy(const RefinementAccuracy& accuracy);

// A table of one row per scene, in Markdown, from what json_accuracy() gave.
[[nodiscard]] std::string accuracy_table_head();
[[nodiscard]] std::string accuracy_table_row(const std::string& scene, const nlohmann::json& accuracy);

}  // namespace lumatlas
