// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

constexpr double kAboveZero = 1e-6;
constexpr double kBelowOne = 1 - 1e-6;

}  // namespace

Settings<AlignmentOptions> alignment_settings() {
  using Options = AlignmentOptions;
  return {
      switch_setting("white-balance", &Options::white_balance,
                     "Correct the exposure of each colour channel on its own"),
      number_setting("prior", &Options::prior, "P", not_negative_rule(),
                     "Strength of the pull towards the given poses; more for poses that are nearly right"),
      number_setting("max-move", &Options::max_move, "SHARE", number_rule(kAboveZero, 1),
                     "Most that a corrected pose may move the picture, as a share of its longer side"),
      number_setting("least-improvement", &Options::least_improvement, "SHARE", number_rule(0, kBelowOne),
                     "Share by which a corrected pose must lower the residual to be accepted"),
      number_setting("least-move", &Options::least_move_px, "PX", not_negative_rule(),
                     "Least movement of the picture, pixels, for which a corrected pose is accepted"),
      whole_setting("levels", &Options::levels, "N", whole_number_rule(1, 64),
                    "Number of pyramid levels to compare, from the finest on"),
      whole_setting("iterations", &Options::max_iterations, "N", whole_number_rule(1, 10000),
                    "Largest number of steps on a level"),
  };
}

Settings<TrustOptions> trust_settings() {
  using Options = TrustOptions;
  return {
      switch_setting("masks", &Options::enabled, "With --refine all or joint, mask what other photographs contradict"),
      whole_setting("grid", &Options::grid_px, "PX", whole_number_rule(8, 65536),
                    "Longer side of the image in which views are compared"),
      number_setting("least-difference", &Options::least_difference, "D", number_rule(kAboveZero, 1),
                     "Least difference of a contradiction, in square roots of linear light"),
      number_setting("least-to-spread", &Options::least_to_spread, "N", not_negative_rule(),
                     "Least difference of a contradiction, in median deviations of the other photographs"),
      whole_setting("least-views", &Options::least_views, "N", whole_number_rule(1, 65536),
                    "Number of other views that a contradiction needs"),
      number_setting("comparable", &Options::comparable_deg, "DEGREES", number_rule(0, 180),
                     "Largest angle between views that can contradict each other"),
      number_setting("highlight", &Options::highlight_deg, "DEGREES", number_rule(0, 180),
                     "Largest angle between views that show the same highlight"),
  };
}

Settings<RefinementOptions> refinement_settings() {
  using Options = RefinementOptions;
  return {
      whole_setting("samples", &Options::samples, "N", whole_number_rule(1, 1u << 20),
                    "Points of the surface at which a view is compared"),
      whole_setting("sample-image", &Options::sample_px, "PX", whole_number_rule(1, 65536),
                    "Longer side of the image in which these points are chosen"),
      whole_setting("revisits", &Options::revisits, "N", whole_number_rule(0, 65536),
                    "Stored views that are refined again after each view that is stored"),
      whole_setting("polish-levels", &Options::polish_levels, "N", whole_number_rule(1, 64),
                    "Levels of the pyramids to compare when stored views are refined again"),
      number_setting("least-correlation", &Options::least_correlation, "C", number_rule(-1, 1),
                     "A view whose correlation with the others stays below this is an outlier"),
      number_setting("least-views", &Options::least_views, "N", not_negative_rule(),
                     "Mean number of other views at its points from which on a view can be an outlier"),
  };
}

}  // namespace lumatlas
