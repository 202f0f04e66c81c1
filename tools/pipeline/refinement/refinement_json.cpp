// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/refinement/refinement_json.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

namespace lumatlas {

namespace {

using nlohmann::json;

bool was_compared(const PlannedView& view) {
  return view.verdict.refinement && view.verdict.refinement->points >= kFewestAlignmentPoints;
}

std::vector<const PlannedView*> compared_views(const BuildResult& result) {
  std::vector<const PlannedView*> views;
  for (const PlannedView& view : result.planned) {
    if (was_compared(view)) views.push_back(&view);
  }
  return views;
}

double mean(const std::vector<const PlannedView*>& views, double Alignment::*field) {
  double sum = 0;
  for (const PlannedView* view : views) sum += view->verdict.refinement->alignment.*field;
  return views.empty() ? 0 : sum / static_cast<double>(views.size());
}

double stops_of(const glm::dvec3& gain) {
  return std::log2((gain.r + gain.g + gain.b) / 3);
}

}  // namespace

const char* name_of(RefineMode mode) {
  switch (mode) {
    case RefineMode::none:
      return "none";
    case RefineMode::exposure:
      return "exposure";
    case RefineMode::pose:
      return "pose";
    case RefineMode::all:
      return "all";
    case RefineMode::joint:
      break;
  }
  return "joint";
}

json refinement_json(const Refinement& refinement, double milliseconds) {
  const Alignment& alignment = refinement.alignment;
  return {{"points", refinement.points},
          {"views_per_point", refinement.views_per_point},
          {"moved_px", alignment.moved_px},
          {"gain", {alignment.gain.r, alignment.gain.g, alignment.gain.b}},
          {"residual_given", alignment.residual_given},
          {"residual_exposed", alignment.residual_exposed},
          {"residual", alignment.residual},
          {"correlation", alignment.correlation ? json(*alignment.correlation) : json()},
          {"ms", milliseconds}};
}

json refinement_summary(const BuildResult& result, RefineMode mode) {
  const std::vector<const PlannedView*> views = compared_views(result);
  const auto moved = std::count_if(views.begin(), views.end(),
                                   [](const PlannedView* view) { return view->verdict.refinement->alignment.moved; });
  json steps = json::array();
  for (const PolishStep& step : result.polish) {
    steps.push_back(
        {{"residual_before", step.residual_before}, {"residual", step.residual_after}, {"moved_px", step.moved_px}});
  }
  json poses;
  if (result.poses) {
    poses = {{"views", result.poses->views},
             {"points", result.poses->points},
             {"residual_before", result.poses->residual_before},
             {"residual", result.poses->residual_after},
             {"improves", result.poses->improves()}};
  }
  return {{"mode", name_of(mode)},
          {"compared", views.size()},
          {"moved", moved},
          {"revisited", result.revisited},
          {"moved_px", mean(views, &Alignment::moved_px)},
          {"residual_given", mean(views, &Alignment::residual_given)},
          {"residual_exposed", mean(views, &Alignment::residual_exposed)},
          {"residual", mean(views, &Alignment::residual)},
          {"poses", std::move(poses)},
          {"polish", {{"steps", std::move(steps)}, {"ms", result.polish_ms}}}};
}

std::string refinement_log(const BuildResult& result) {
  std::ostringstream log;
  log << std::fixed;
  for (const PlannedView* view : compared_views(result)) {
    const Refinement& refinement = *view->verdict.refinement;
    const Alignment& alignment = refinement.alignment;
    log << "refine: " << view->name << ": residual " << std::setprecision(4) << alignment.residual_given << " -> "
        << alignment.residual << ", moved " << std::setprecision(2) << alignment.moved_px << " px, exposure "
        << std::showpos << stops_of(alignment.gain) << std::noshowpos << " EV, ";
    alignment.correlation ? log << "correlation " << *alignment.correlation : log << "too plain to correlate";
    log << (refinement.outlier ? ": dropped as an outlier" : "") << '\n';
  }
  if (result.poses) {
    log << "poses: " << result.poses->views << " views together: residual at points held out " << std::setprecision(4)
        << result.poses->residual_before << " -> " << result.poses->residual_after
        << (result.poses->improves() ? "" : ", left as they were") << '\n';
  }
  for (std::size_t step = 0; step < result.polish.size(); ++step) {
    log << "polish: step " << step + 1 << ": residual " << std::setprecision(4) << result.polish[step].residual_before
        << " -> " << result.polish[step].residual_after << '\n';
  }
  return log.str();
}

}  // namespace lumatlas
