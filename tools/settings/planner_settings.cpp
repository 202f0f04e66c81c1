// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

enum class Metric { directions, departures, printed };

// Delta_scov and Delta_fcov of section 3.2 for the paper's measure, by which a cell counts up to fcov_max and not up to
// 1.
constexpr double kPaperMinViewGain = 0.1;
constexpr double kPaperMinReferenceGain = 0.01;

const Settings<CoverageDepartures>& departure_table() {
  static const Settings<CoverageDepartures> table = departure_settings();
  return table;
}

Metric metric_of(const PlannerOptions& options) {
  if (options.coverage.metric == CoverageOptions::Metric::directions) return Metric::directions;
  const bool printed = values_of(departure_table(), options.coverage.departures) ==
                       values_of(departure_table(), CoverageDepartures::none());
  return printed ? Metric::printed : Metric::departures;
}

void set_metric(PlannerOptions& options, Metric metric) {
  const PlannerOptions ours;
  const bool paper = metric != Metric::directions;
  options.coverage.metric = paper ? CoverageOptions::Metric::paper : CoverageOptions::Metric::directions;
  options.coverage.departures = metric == Metric::printed ? CoverageDepartures::none() : ours.coverage.departures;
  options.min_view_gain = paper ? kPaperMinViewGain : ours.min_view_gain;
  options.min_reference_gain = paper ? kPaperMinReferenceGain : ours.min_reference_gain;
}

Setting<PlannerOptions> metric_setting() {
  Setting<PlannerOptions> row = named_setting<PlannerOptions, Metric>(
      "coverage.metric",
      {{"directions", Metric::directions}, {"departures", Metric::departures}, {"printed", Metric::printed}}, metric_of,
      set_metric,
      "Measure of coverage: how well novel directions are served, the paper's with departures, or the paper's as "
      "printed; the latter two set planner.min-gain " +
          value_text(kPaperMinViewGain) + " and planner.min-reference-gain " + value_text(kPaperMinReferenceGain));
  row.sets_others = true;
  return row;
}

Settings<PlannerOptions> gain_settings() {
  using Options = PlannerOptions;
  return {
      number_setting("planner.min-gain", &Options::min_view_gain, "GAIN", not_negative_rule(),
                     "Coverage that a view must add, as a share of the cells that it sees"),
      number_setting("planner.min-exchange-gain", &Options::min_exchange_gain, "GAIN", not_negative_rule(),
                     "Coverage that a view must add to take another's place, as a share of what a stored view is worth "
                     "on average; at 1, with planner.min-gain 0, coverage.metric directions, no --budget and no "
                     "outliers, the store is never worth less than a quarter of the best"),
      number_setting("planner.min-reference-gain", &Options::min_reference_gain, "GAIN", not_negative_rule(),
                     "Coverage that a view must add to a cell with all its references to replace one of them"),
      whole_setting("planner.victims", &Options::victims, "N", whole_number_rule(0, 1u << 20),
                    "Number of stored views considered for replacement, those of least loss first; 0: all"),
      whole_setting("planner.visibility", &Options::visibility_px, "PX", whole_number_rule(1, 65536),
                    "Longer side of the image that cells are counted in"),
  };
}

}  // namespace

Settings<PlannerOptions> planner_settings() {
  using Options = PlannerOptions;
  const auto departures_of = [](auto& options) -> auto& {
    return options.coverage.departures;
  };
  const auto alignment = [](auto& options) -> auto& {
    return options.refinement.alignment;
  };
  const auto trust = [](auto& options) -> auto& {
    return options.refinement.trust;
  };
  return joined<Options>({{metric_setting()},
                          within<Options>("coverage.", coverage_settings(), &Options::coverage),
                          within<Options>("departures.", departure_settings(), departures_of),
                          gain_settings(),
                          within<Options>("refinement.", refinement_settings(), &Options::refinement),
                          within<Options>("alignment.", alignment_settings(), alignment),
                          within<Options>("trust.", trust_settings(), trust),
                          within<Options>("masks.", mask_settings(), &Options::validity)});
}

}  // namespace lumatlas
