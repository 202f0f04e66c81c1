// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

using Comparison = CoverageDepartures::Comparison;

// Novel directions of a cell; more of them than this change nothing.
constexpr std::uint32_t kMostDirections = 4096;
constexpr std::uint32_t kMostReferences = 1u << 16;
constexpr double kNarrowestDegrees = 1e-3;

}  // namespace

Settings<CoverageOptions> coverage_settings() {
  using Options = CoverageOptions;
  return {
      number_setting("direction-weight", &Options::lambda, "W", number_rule(0, 1),
                     "Weight of direction against position when views are chosen"),
      number_setting("ideal-distance", &Options::ideal_distance, "LENGTH", not_negative_rule(),
                     "Camera distance at which a cell is covered best, scene units, 0: the scene's median; with "
                     "coverage.demand off, or coverage.metric departures or printed"),
      number_setting(
          "distance-sigma", &Options::distance_sigma, "LENGTH", not_negative_rule(),
          "Offset from the ideal distance at which coverage falls to 0.6, scene units, 0: half of that distance"),
      whole_setting("references", &Options::max_references, "N", whole_number_rule(1, kMostReferences),
                    "Views that a cell may refer to"),
      number_setting("max-cell-coverage", &Options::max_cell_coverage, "C", not_negative_rule(),
                     "With coverage.metric departures or printed, coverage above which a cell counts no further "
                     "views, 0: half of coverage.references"),
      switch_setting("demand", &Options::demand,
                     "With coverage.metric directions, weigh cells by how large and from how far the offered views see "
                     "them; off: cells count alike and have one ideal distance"),
      number_setting(
          "demand-prior", &Options::demand_prior, "N", not_negative_rule(),
          "With coverage.demand, number of imagined views without a cell that its mean over all views counts"),
      whole_setting("directions", &Options::directions, "N", whole_number_rule(1, kMostDirections),
                    "With coverage.metric directions, number of novel directions that are spread over a cell"),
      number_setting("direction-width", &Options::direction_width, "DEGREES", number_rule(kNarrowestDegrees, 180),
                     "With coverage.metric directions, degrees from a novel direction beyond which a view does not "
                     "serve it"),
      number_setting("reference-width", &Options::reference_width, "DEGREES", number_rule(kNarrowestDegrees, 180),
                     "coverage.direction-width where a cell's references are chosen"),
      number_setting("reference-direction-weight", &Options::reference_lambda, "W", number_rule(0, 1),
                     "coverage.direction-weight where a cell's references are chosen"),
      whole_setting("views-per-direction", &Options::views_per_direction, "N",
                    whole_number_rule(1, Options::kMostViewsPerDirection),
                    "With coverage.metric directions, number of best views that a novel direction counts"),
  };
}

Settings<CoverageDepartures> departure_settings() {
  using Options = CoverageDepartures;
  const std::string with_paper = "With coverage.metric departures or printed, ";
  return {
      choice_setting(
          "comparison", &Options::comparison,
          {{"earlier", Comparison::earlier}, {"others", Comparison::others}, {"everyone", Comparison::everyone}},
          with_paper + "which views a stored view is compared with: those before it, all others, or, as "
                       "printed, itself too"),
      switch_setting("first-view", &Options::first_view,
                     with_paper + "let an empty cell give its first view directional coverage; printed: off"),
      switch_setting("hemisphere", &Options::hemisphere,
                     with_paper + "bound directions on the half of the sphere that sees a surface; printed: off"),
      switch_setting("share", &Options::bounded_share,
                     with_paper + "let a view count at most all pixels of a cell; printed: off"),
      switch_setting("references", &Options::references,
                     with_paper + "count the references of a cell alone, not all stored views; printed: off"),
  };
}

}  // namespace lumatlas
