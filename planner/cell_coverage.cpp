// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/cell_coverage.h"

#include "planner/direction_coverage.h"
#include "planner/paper_coverage.h"

namespace lumatlas {

std::unique_ptr<CellCoverage> make_cell_coverage(const Surface& surface, const CoverageOptions& options,
                                                 double min_reference_gain) {
  if (options.metric == CoverageOptions::Metric::paper) {
    return std::make_unique<PaperCoverage>(surface.cells.cells.size(), options, min_reference_gain);
  }
  return std::make_unique<DirectionCoverage>(surface, options, min_reference_gain);
}

}  // namespace lumatlas
