// SPDX-License-Identifier: GPL-3.0-or-later
// The options of coverage, and what must be gained by it, for commands that plan.
#pragma once

#include <CLI/App.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planner/planner.h"

namespace lumatlas {

class CoverageFlags {
 public:
  // --references, which belongs beside what bounds a model.
  void add_references_to(CLI::App& command);
  // All others.
  void add_experiments_to(CLI::App& command);

  // --paper: the printed measure, with its thresholds. Throws CLI::ValidationError for an option that says otherwise.
  void follow_paper();
  // Throws CLI::ValidationError for options that do not go together.
  void apply(PlannerOptions& options) const;
  // Sets the options that were given once more, after apply_budget() has set those that a bound on the loss needs.
  // Throws CLI::ValidationError for a measure that no loss can be predicted by.
  void keep_given(PlannerOptions& options) const;

 private:
  enum class Metric { directions, departures, printed };

  void add_measure_to(CLI::App& command);
  void add_directions_to(CLI::App& command);
  void add_references_measure_to(CLI::App& command);
  void add_gains_to(CLI::App& command);

  CoverageOptions values_;
  std::optional<double> min_view_gain_, min_reference_gain_;  // none: as the measure wants them
  Metric metric_ = Metric::directions;
  std::vector<std::string> depart_;
  bool no_demand_ = false;
  CLI::Option* metric_option_ = nullptr;
  CLI::Option* depart_option_ = nullptr;
  CLI::Option* min_gain_option_ = nullptr;
  CLI::Option* min_reference_gain_option_ = nullptr;
  CLI::Option* ideal_distance_option_ = nullptr;
  CLI::Option* references_option_ = nullptr;
  CLI::Option* weight_option_ = nullptr;
  CLI::Option* width_option_ = nullptr;
};

}  // namespace lumatlas
