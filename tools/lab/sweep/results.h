// SPDX-License-Identifier: GPL-3.0-or-later
// Collects what the points of a sweep say together: means over the seeds, where methods break, fronts; as CSV and JSON.
#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/lab/sweep/metrics.h"
#include "tools/lab/sweep/runner.h"

namespace lumatlas {

// A figure over the seeds of one value.
struct Repeated {
  double mean = 0, least = 0, most = 0;
  double deviation = 0;  // of the sample; 0 of a single run
  std::size_t runs = 0;
};
[[nodiscard]] Repeated repeated(std::span<const double> values);  // of at least one

// A series on one scene.
struct Curve {
  std::size_t scene = 0, series = 0;                    // of the sweep
  std::vector<std::map<std::string, Repeated>> values;  // of the series, in its order: figures by metric
};

// Returns the curves of every scene and series, in the sweep's order; values without a point that is done have no
// figures.
[[nodiscard]] std::vector<Curve> curves_of(const Sweep& sweep, const std::vector<PointResult>& results);

// The index of the first of `figures` that is worse than the first of them by `fall` or more; none: it does not break,
// or there is no first figure. Figures that are missing are passed over.
[[nodiscard]] std::optional<std::size_t> breaking_point(std::span<const std::optional<double>> figures, double fall,
                                                        bool more_is_better);

// A curve's breaking point by the sweep's rule, as an index of the series' values; the sweep must have a rule.
[[nodiscard]] std::optional<std::size_t> breaking_point(const Sweep& sweep, const Curve& curve);

// The points of a plot's front on one scene, by curve and value.
struct OnFront {
  std::size_t curve = 0, value = 0;
};
[[nodiscard]] std::vector<OnFront> front_of(const std::vector<Curve>& curves, std::size_t scene, const std::string& x,
                                            const std::string& y);

// One row a point: scene, series, mark, value, x, seed, status, reason, program, and every metric that any point has,
// in the order of all_metrics(); a loss is measured against the series' first value. RFC 4180: comma, quotes where they
// are needed, lines end in CR LF.
[[nodiscard]] std::string results_csv(const Sweep& sweep, const std::vector<PointResult>& results);

// {"sweep": {...}, "points": [{"scene", "series", "value", "x", "seed", "status", "reason", "made_by", "commands",
// "figures": {...}}], "curves": [{"scene", "series", "values": [{"value", "figures": {METRIC: {"mean", "least", "most",
// "deviation", "runs"}}}]}], "breaking": [{"scene", "series", "at"}]}
[[nodiscard]] nlohmann::json results_json(const Sweep& sweep, const std::vector<PointResult>& results);

}  // namespace lumatlas
