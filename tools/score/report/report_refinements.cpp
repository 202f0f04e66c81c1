// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/report/report_refinements.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "planner/refinement/refiner.h"

namespace lumatlas {

std::vector<ReportRefinement> read_refinements(const nlohmann::json& document) {
  std::vector<ReportRefinement> refinements;
  if (!document.is_object() || !document.contains("views") || !document["views"].is_array()) return refinements;
  for (const nlohmann::json& view : document["views"]) {
    if (!view.is_object() || !view.contains("refinement")) continue;
    try {
      const nlohmann::json& refinement = view["refinement"];
      const auto gain = refinement.at("gain").get<std::vector<double>>();
      if (refinement.at("points").get<std::size_t>() < kFewestAlignmentPoints || gain.size() != 3) continue;
      refinements.push_back({view.at("name"), view.at("decision"), refinement.at("residual_given"),
                             refinement.at("residual_exposed"), refinement.at("residual"), refinement.at("moved_px"),
                             std::log2((gain[0] + gain[1] + gain[2]) / 3)});
    } catch (const nlohmann::json::exception&) {
      return {};  // another program's file: a report can do without
    }
  }
  return refinements;
}

}  // namespace lumatlas
