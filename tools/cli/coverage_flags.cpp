// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/coverage_flags.h"

#include <CLI/Error.hpp>
#include <stdexcept>

#include "tools/cli/commands.h"
#include "tools/cli/option_rules.h"
#include "tools/pipeline/coverage_names.h"

namespace lumatlas {

namespace {

// Delta_scov and Delta_fcov of section 3.2 for the paper's measure, by which a cell counts up to fcov_max and not up to
// 1.
constexpr double kPaperMinViewGain = 0.1;
constexpr double kPaperMinReferenceGain = 0.01;

std::string default_gain(double of_directions, double of_paper) {
  return CLI::detail::to_string(of_directions) + ", of the paper's measure " + CLI::detail::to_string(of_paper);
}

CoverageDepartures departures_of(const std::vector<std::string>& names) {
  try {
    return departures_named(names);
  } catch (const std::invalid_argument& error) {
    throw CLI::ValidationError("--depart", error.what());
  }
}

}  // namespace

void CoverageFlags::add_references_to(CLI::App& command) {
  references_option_ = command.add_option("--references", values_.max_references, "Views that a cell may refer to")
                           ->type_name("N")
                           ->transform(whole_number(1, 1u << 16));
}

void CoverageFlags::add_experiments_to(CLI::App& command) {
  begin_experiments(command, "the measure by which views are chosen");
  add_measure_to(command);
  add_directions_to(command);
  begin_experiments(command, "the measure by which a cell's references are chosen");
  add_references_measure_to(command);
  begin_experiments(command, "what a view must gain");
  add_gains_to(command);
}

void CoverageFlags::add_measure_to(CLI::App& command) {
  metric_option_ = add_choice(
      command, "--metric", metric_,
      {{"directions", Metric::directions}, {"departures", Metric::departures}, {"printed", Metric::printed}},
      "Coverage: how well novel directions are served, or the paper's measure where departures from it are better, or "
      "as printed");
  depart_option_ = command
                       .add_option("--depart", depart_,
                                   "With --metric departures or printed, depart in these alone, separated by commas")
                       ->type_name("NAMES")
                       ->delimiter(',')
                       ->check(one_of(departure_names()))
                       ->default_str("");
  weight_option_ = command
                       .add_option("--coverage-direction-weight", values_.lambda,
                                   "Weight of direction against position when views are chosen")
                       ->type_name("W")
                       ->check(number_between(0, 1));
  ideal_distance_option_ =
      command
          .add_option("--ideal-distance", values_.ideal_distance,
                      "Camera distance at which a cell is covered best, scene units, 0: the scene's median; with "
                      "--no-demand, or --metric departures or printed")
          ->type_name("LENGTH")
          ->check(finite_not_negative());
  command
      .add_option("--distance-sigma", values_.distance_sigma,
                  "How far from it coverage falls to 0.6, scene units, 0: half of it")
      ->type_name("LENGTH")
      ->check(finite_not_negative());
  command
      .add_option(
          "--max-cell-coverage", values_.max_cell_coverage,
          "With --metric departures or printed, coverage above which a cell counts no further views, 0: half of "
          "--references")
      ->type_name("C")
      ->check(finite_not_negative());
}

void CoverageFlags::add_directions_to(CLI::App& command) {
  command.add_flag(
      "--no-demand", no_demand_,
      "With --metric directions, let cells count alike and have one ideal distance, instead of by how large "
      "and from how far the offered views see them");
  command
      .add_option("--demand-prior", values_.demand_prior,
                  "With --metric directions, views that do not see a cell, added to those that do")
      ->type_name("N")
      ->check(finite_not_negative());
  command
      .add_option("--directions", values_.directions,
                  "With --metric directions, novel directions in which a cell is to be shown")
      ->type_name("N")
      ->transform(whole_number(1, 4096));
  width_option_ = command
                      .add_option("--direction-width", values_.direction_width,
                                  "With --metric directions, degrees from a novel direction beyond which a view does "
                                  "not serve it")
                      ->type_name("DEGREES")
                      ->check(number_between(1e-3, 180));
  command
      .add_option("--views-per-direction", values_.views_per_direction,
                  "With --metric directions, how many of its best views a novel direction counts")
      ->type_name("N")
      ->transform(whole_number(1, CoverageOptions::kMostViewsPerDirection));
}

void CoverageFlags::add_references_measure_to(CLI::App& command) {
  command
      .add_option("--reference-width", values_.reference_width,
                  "With --metric directions, what --direction-width is where references are chosen")
      ->type_name("DEGREES")
      ->check(number_between(1e-3, 180));
  command
      .add_option("--reference-direction-weight", values_.reference_lambda,
                  "With --metric directions, weight of direction against position where references are chosen")
      ->type_name("W")
      ->check(number_between(0, 1));
}

void CoverageFlags::add_gains_to(CLI::App& command) {
  min_gain_option_ = command
                         .add_option("--min-gain", min_view_gain_,
                                     "Coverage that a view must add, as a share of the cells that it sees")
                         ->type_name("GAIN")
                         ->check(finite_not_negative())
                         ->default_str(default_gain(PlannerOptions{}.min_view_gain, kPaperMinViewGain));
  min_reference_gain_option_ =
      command
          .add_option("--min-reference-gain", min_reference_gain_,
                      "Coverage that a view must add to a full cell to take a reference's place")
          ->type_name("GAIN")
          ->check(finite_not_negative())
          ->default_str(default_gain(PlannerOptions{}.min_reference_gain, kPaperMinReferenceGain));
}

void CoverageFlags::follow_paper() {
  agree_with_paper(*metric_option_, metric_ == Metric::printed, "printed");
  agree_with_paper(*depart_option_, depart_.empty(), "without departures");
  agree_with_paper(*min_gain_option_, min_view_gain_ == kPaperMinViewGain, CLI::detail::to_string(kPaperMinViewGain));
  agree_with_paper(*min_reference_gain_option_, min_reference_gain_ == kPaperMinReferenceGain,
                   CLI::detail::to_string(kPaperMinReferenceGain));
  metric_ = Metric::printed;
}

void CoverageFlags::apply(PlannerOptions& options) const {
  options.coverage = values_;
  if (metric_ == Metric::directions) {
    if (depart_option_->count() > 0) {
      throw CLI::ValidationError("--depart", "needs --metric departures or --metric printed");
    }
    options.coverage.demand = !no_demand_;
    if (options.coverage.demand && ideal_distance_option_->count() > 0) {
      throw CLI::ValidationError("--ideal-distance", "needs --no-demand, or --metric departures or printed");
    }
  } else {
    options.coverage.metric = CoverageOptions::Metric::paper;
    options.min_view_gain = kPaperMinViewGain;
    options.min_reference_gain = kPaperMinReferenceGain;
    if (metric_ == Metric::printed) options.coverage.departures = CoverageDepartures::none();
    if (depart_option_->count() > 0) options.coverage.departures = departures_of(depart_);
  }
  options.min_view_gain = min_view_gain_.value_or(options.min_view_gain);
  options.min_reference_gain = min_reference_gain_.value_or(options.min_reference_gain);
}

void CoverageFlags::keep_given(PlannerOptions& options) const {
  if (metric_ != Metric::directions) throw CLI::ValidationError("--budget auto", "needs --metric directions");
  if (weight_option_->count() > 0) options.coverage.lambda = values_.lambda;
  if (width_option_->count() > 0) options.coverage.direction_width = values_.direction_width;
  if (references_option_->count() > 0) options.coverage.max_references = values_.max_references;
  options.min_view_gain = min_view_gain_.value_or(options.min_view_gain);
}

}  // namespace lumatlas
