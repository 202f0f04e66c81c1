// SPDX-License-Identifier: GPL-3.0-or-later
// Measures of coverage by the names that the command line and the files beside an output give them.
#pragma once

#include <string>
#include <vector>

#include "planner/coverage/coverage.h"

namespace lumatlas {

// "directions", "printed", or "departures" for the paper's measure with any departure from the print.
[[nodiscard]] std::string metric_name(const CoverageOptions& options);

// first-view, hemisphere, share, references, and of the comparisons earlier or others: CoverageDepartures has what they
// mean. Those that are on, in this order.
[[nodiscard]] const std::vector<std::string>& departure_names();
[[nodiscard]] std::vector<std::string> departure_names(const CoverageDepartures& departures);

// With these and no others. Throws std::invalid_argument for a name that is none of them, and for both comparisons.
[[nodiscard]] CoverageDepartures departures_named(const std::vector<std::string>& names);

}  // namespace lumatlas
