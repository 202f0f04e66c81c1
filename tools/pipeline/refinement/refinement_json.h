// SPDX-License-Identifier: GPL-3.0-or-later
// The results of refinement for plan.json, for the summary of a build, and for its log.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "planner/refinement/refiner.h"
#include "tools/pipeline/build_model.h"

namespace lumatlas {

[[nodiscard]] const char* name_of(RefineMode mode);

// One view's part of plan.json.
[[nodiscard]] nlohmann::json refinement_json(const Refinement& refinement, double milliseconds);

// Counts and means over the views that were compared with others, and the steps of joint polishing.
[[nodiscard]] nlohmann::json refinement_summary(const BuildResult& result, RefineMode mode);

// One line a view: what was done to it and why.
[[nodiscard]] std::string refinement_log(const BuildResult& result);

}  // namespace lumatlas
