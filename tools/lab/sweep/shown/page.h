// SPDX-License-Identifier: GPL-3.0-or-later
// Sweeps as a web page that works offline: one file, which loads nothing and runs no script.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tools/lab/sweep/results.h"

namespace lumatlas {

struct SweepReport {
  Sweep sweep;
  std::vector<PointResult> results;  // as SweepRunner::run() gives them
  std::vector<std::string> plots;    // the text of an SVG file each, as Sweep::plots; empty: there is none
};

struct ChartPage {
  std::string program;                                     // the identity of the one that runs, as made_by of points
  std::vector<std::pair<std::string, std::string>> facts;  // of the run: what, value
  std::vector<std::string> notes;                          // one sentence each, that a reader must know
  std::vector<SweepReport> sweeps;
};

[[nodiscard]] std::string chart_page(const ChartPage& page);

// Returns what the page says below a plot with a front: which marked series have a point on it. One sentence a scene
// and y; none for a plot without a front.
[[nodiscard]] std::vector<std::string> front_sentences(const Sweep& sweep, const SweepPlot& plot,
                                                       const std::vector<Curve>& curves);

// Returns where each series breaks, one sentence a scene and series that has figures; none without a rule.
[[nodiscard]] std::vector<std::string> breaking_sentences(const Sweep& sweep, const std::vector<Curve>& curves);

// Returns a sentence on the programs that made the points; empty if `program` made them all.
[[nodiscard]] std::string makers_sentence(const std::vector<PointResult>& results, const std::string& program);

// The table of a scene: a head and a row for each value of each series that has figures, the sweep's metrics as mean
// and, of several runs, (least..most).
using TextRow = std::vector<std::string>;
[[nodiscard]] std::vector<TextRow> results_table(const Sweep& sweep, const std::vector<Curve>& curves,
                                                 std::size_t scene);

}  // namespace lumatlas
