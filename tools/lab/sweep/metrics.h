// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of a model that sweeps plot, by name, from what `build --json` and `validate --json` say.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

namespace lumatlas {

enum class Better { more, less, neither };

struct Metric {
  std::string name;   // "psnr.fitted", "psnr.fitted.vertex", "time.plan"
  std::string label;  // for people, with the unit: "PSNR fitted, dB"
  Better better = Better::neither;
  int decimals = 0;  // that are worth showing
};

// All of them. Scores (psnr, ssim, textured, seams, flicker) are the model's; ".unbounded" or ".vertex" at the end of
// the name asks for a baseline's. "psnr.raw" is over the pixels of the mesh, "psnr.frame.raw" over whole frames.
[[nodiscard]] std::span<const Metric> all_metrics();

// Null if there is none of this name.
[[nodiscard]] const Metric* find_metric(const std::string& name);

using Figures = std::map<std::string, double>;  // by the metric's name, finite

// Returns the figures that these results hold; a figure that was not measured is absent.
[[nodiscard]] Figures figures_of(const nlohmann::json& build, const nlohmann::json& scores);

// Adds "loss.measured", by how much the model looks worse than one that gave nothing up, to the figures of a model
// whose loss was predicted; nothing if it was not, or if one of both was not scored.
void add_measured_loss(Figures& figures, const Figures& of_whole);

}  // namespace lumatlas
