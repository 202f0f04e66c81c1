// SPDX-License-Identifier: GPL-3.0-or-later
// The refinements of a model's views, read from the plan.json that `build` wrote beside it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "tools/score/report/report.h"

namespace lumatlas {

// The views that were compared with others, in the plan's order; empty for anything that is not such a plan.
[[nodiscard]] std::vector<ReportRefinement> read_refinements(const nlohmann::json& plan);

}  // namespace lumatlas
