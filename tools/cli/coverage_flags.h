// SPDX-License-Identifier: GPL-3.0-or-later
// The options of coverage, and what must be gained by it, for commands that plan.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Error.hpp>
#include <CLI/Validators.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "planner/planner.h"
#include "planner/predicted_loss.h"
#include "tools/cli/number_flags.h"
#include "tools/pipeline/coverage_names.h"

namespace lumatlas {

// Delta_scov and Delta_fcov of section 3.2 for the paper's measure, by which a cell counts up to fcov_max and not up to
// 1.
inline constexpr double kPaperMinViewGain = 0.1;
inline constexpr double kPaperMinReferenceGain = 0.01;

struct CoverageFlags {
  CoverageOptions values;
  std::optional<double> min_view_gain, min_reference_gain;  // none: as the measure wants them
  std::string metric = "directions";
  std::vector<std::string> depart;
  bool no_demand = false;
  CLI::Option* depart_option = nullptr;
  CLI::Option* ideal_distance_option = nullptr;
  CLI::Option* references_option = nullptr;
  CLI::Option* lambda_option = nullptr;
  CLI::Option* width_option = nullptr;

  void add_to(CLI::App& command) {
    command
        .add_option(
            "--metric", metric,
            "Measure of coverage: directions (how well novel directions are served), printed (the paper's to the "
            "letter) or departures (the paper's, departing from the print where that is better)")
        ->check(CLI::IsMember({"directions", "departures", "printed"}));
    depart_option =
        command
            .add_option(
                "--depart", depart,
                "With --metric departures or printed: depart from the print in these alone, separated by commas: "
                "first-view, hemisphere, share, references, and either earlier or others")
            ->delimiter(',')
            ->check(CLI::IsMember(departure_names()))
            ->default_str("");
    references_option = command.add_option("--references", values.max_references, "Views that a cell may refer to");
    references_option->check(CLI::Range(1u, 1u << 16));
    lambda_option = command.add_option("--coverage-lambda", values.lambda,
                                       "Weight of direction against position when views are chosen");
    lambda_option->check(number_between(0, 1));
    ideal_distance_option =
        command
            .add_option("--ideal-distance", values.ideal_distance,
                        "Camera distance at which a cell is covered best, scene units; 0: the scene's median; needs "
                        "--no-demand or --metric departures or printed")
            ->check(finite_not_negative());
    command
        .add_option("--distance-sigma", values.distance_sigma,
                    "How far from it coverage falls to 0.6, scene units; 0: half of it")
        ->check(finite_not_negative());
    add_directions_to(command);
    add_gains_to(command);
    command
        .add_option(
            "--max-cell-coverage", values.max_cell_coverage,
            "With --metric departures or printed: coverage above which a cell counts no further views; 0: half of "
            "--references")
        ->check(finite_not_negative());
  }

  // What a bound on the predicted loss needs where nothing else was asked for: the measure that the law is for, and
  // that nothing is turned away which adds something.
  void apply_parsimony(PlannerOptions& options) const {
    constexpr std::uint32_t kReferences = 64;
    if (metric != "directions") throw CLI::ValidationError("--budget auto", "needs --metric directions");
    const CoverageOptions wanted = parsimony_coverage(options.coverage);
    if (lambda_option->count() == 0) options.coverage.lambda = wanted.lambda;
    if (width_option->count() == 0) options.coverage.direction_width = wanted.direction_width;
    if (references_option->count() == 0) options.coverage.max_references = kReferences;
    options.min_view_gain = min_view_gain.value_or(0);
  }

  void apply(PlannerOptions& options) const {
    options.coverage = values;
    if (metric == "directions") {
      if (depart_option->count() > 0) {
        throw CLI::ValidationError("--depart", "needs --metric departures or --metric printed");
      }
      options.coverage.demand = !no_demand;
      if (options.coverage.demand && ideal_distance_option->count() > 0) {
        throw CLI::ValidationError("--ideal-distance", "needs --no-demand, or --metric departures or printed");
      }
    } else {
      options.coverage.metric = CoverageOptions::Metric::paper;
      options.min_view_gain = kPaperMinViewGain;
      options.min_reference_gain = kPaperMinReferenceGain;
      if (metric == "printed") options.coverage.departures = CoverageDepartures::none();
      if (depart_option->count() > 0) options.coverage.departures = departures();
    }
    options.min_view_gain = min_view_gain.value_or(options.min_view_gain);
    options.min_reference_gain = min_reference_gain.value_or(options.min_reference_gain);
  }

 private:
  [[nodiscard]] CoverageDepartures departures() const {
    try {
      return departures_named(depart);
    } catch (const std::invalid_argument& error) {
      throw CLI::ValidationError("--depart", error.what());
    }
  }

  void add_directions_to(CLI::App& command) {
    command.add_flag("--no-demand", no_demand,
                     "With --metric directions: let cells count alike, and have one ideal distance, instead of by how "
                     "large and from how far the offered views see them");
    command
        .add_option("--demand-prior", values.demand_prior,
                    "With --metric directions: views that do not see a cell, added to those that do")
        ->check(finite_not_negative());
    command
        .add_option("--directions", values.directions,
                    "With --metric directions: novel directions in which a cell is to be shown")
        ->check(CLI::Range(1u, 4096u));
    width_option =
        command.add_option("--direction-width", values.direction_width,
                           "With --metric directions: degrees from a novel direction beyond which a view does not "
                           "serve it");
    width_option->check(number_between(1e-3, 180));
    command
        .add_option("--reference-width", values.reference_width,
                    "With --metric directions: the same where a cell's references are chosen")
        ->check(number_between(1e-3, 180));
    command
        .add_option(
            "--reference-lambda", values.reference_lambda,
            "With --metric directions: weight of direction against position where a cell's references are chosen")
        ->check(number_between(0, 1));
    command
        .add_option("--views-per-direction", values.views_per_direction,
                    "With --metric directions: how many of its best views a novel direction counts")
        ->check(CLI::Range(1u, CoverageOptions::kMostViewsPerDirection));
  }

  void add_gains_to(CLI::App& command) {
    const std::string otherwise = "; with --metric departures or printed ";
    command
        .add_option("--min-gain", min_view_gain,
                    "Coverage that a view must add, as a share of the cells that it sees" + otherwise +
                        CLI::detail::to_string(kPaperMinViewGain))
        ->check(finite_not_negative())
        ->default_str(CLI::detail::to_string(PlannerOptions{}.min_view_gain));
    command
        .add_option("--min-reference-gain", min_reference_gain,
                    "Coverage that a view must add to a full cell to take a reference's place" + otherwise +
                        CLI::detail::to_string(kPaperMinReferenceGain))
        ->check(finite_not_negative())
        ->default_str(CLI::detail::to_string(PlannerOptions{}.min_reference_gain));
  }
};

}  // namespace lumatlas
