// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/output/worth_saving.h"

#include <algorithm>
#include <sstream>
#include <string>

#include "mesh/base/errors.h"
#include "tools/scene/scene.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

std::size_t count_views(const Snapshot& snapshot) {
  return static_cast<std::size_t>(
      std::count_if(snapshot.views.begin(), snapshot.views.end(), [](const auto& view) { return view != nullptr; }));
}

// Why none of the photographs is stored.
std::string why_nothing_is_stored(const BuildResult& result, const PhotographsUsed& used) {
  std::ostringstream sentence;
  sentence << "none of the " << used.wanted << " photographs is stored, so that no model was saved: ";
  if (const std::size_t missing = used.wanted - std::min(used.wanted, result.planned.size()); missing > 0) {
    sentence << missing << " did not come, or are damaged";
    if (result.planned.empty()) return sentence.str();
    sentence << ", ";
  }
  std::size_t blind = 0, outliers = 0;
  for (const PlannedView& view : result.planned) {
    if (view.verdict.cells_seen == 0) ++blind;
    if (view.verdict.decision == Decision::outlier) ++outliers;
  }
  sentence << blind << " see nothing of the mesh, " << outliers << " disagree with the others, "
           << result.planned.size() - blind - outliers << " would add too little at an ideal distance of "
           << result.effective.coverage.ideal_distance << " (setting coverage.ideal-distance)";
  return sentence.str();
}

bool is_there(const fs::path& output) {
  std::error_code ignored;
  return fs::is_directory(output, ignored) ? !fs::is_empty(output, ignored) : fs::exists(output, ignored);
}

}  // namespace

PhotographsUsed photographs_used(const BuildResult& result, std::size_t unplaced) {
  const auto& hold_out = result.options.hold_out;
  const auto outliers = std::count_if(result.planned.begin(), result.planned.end(), [](const PlannedView& view) {
    return view.verdict.decision == Decision::outlier;
  });
  return {unplaced + (hold_out ? split(result.views, *hold_out).input.size() : result.views - result.listed_to_score),
          result.planned.size() - static_cast<std::size_t>(outliers), count_views(result.snapshot)};
}

void require_worth_saving(const BuildResult& result, std::size_t unplaced, const fs::path& output) {
  const PhotographsUsed used = photographs_used(result, unplaced);
  if (used.stored == 0) throw InputError(output.string() + ": " + why_nothing_is_stored(result, used));
  if (2 * used.looked_at >= used.wanted || !is_there(output)) return;
  throw InputError(output.string() + ": stays as it is, because the new model misses most of its photographs (" +
                   std::to_string(used.looked_at) + " of " + std::to_string(used.wanted) +
                   " could be used): name another output, or remove the earlier model");
}

void require_views(const Snapshot& snapshot, const fs::path& model) {
  if (count_views(snapshot) > 0) return;
  throw InputError(model.string() + ": holds no photograph, so that there is nothing to export: build it anew");
}

}  // namespace lumatlas
