// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

// ", printed 0" where the paper has another value than the default.
std::string and_printed(const Setting<BlendOptions>& row) {
  const nlohmann::json printed = row.get(BlendOptions::printed());
  return printed == row.get(BlendOptions()) ? "" : "; printed: " + setting_text(printed);
}

Settings<BlendOptions> blend_fields() {
  using Options = BlendOptions;
  return {
      whole_setting("views", &Options::views, "N", whole_number_rule(1, kMaxBlendedViews),
                    "Number of views blended at a pixel: the paper's K"),
      number_setting("direction-weight", &Options::lambda, "W", number_rule(0, 1),
                     "Weight of direction against distance when views are blended"),
      choice_setting(
          "position", &Options::position,
          {{"ratio", Options::Position::ratio}, {"printed", Options::Position::printed}},
          "Weight by a view's distance: 1 at the distance of the picture's camera, falling both ways; printed: growing "
          "with the view's distance"),
      switch_setting("rims", &Options::rims,
                     "Show the nearer side of a depth edge in pictures from near the photograph's camera"),
      switch_setting("fade-last", &Options::fade_last,
                     "Subtract the weight of the best view that is not blended, so that views enter and leave at 0"),
      switch_setting("consistent", &Options::consistent, "Show one photograph alone in a picture from its own camera"),
      number_setting("frame-fade", &Options::frame_fade, "SHARE", number_rule(0, 0.5),
                     "Width over which a view fades out at its photograph's border, as a share of the shorter side"),
      choice_setting("sampling", &Options::sampling,
                     {{"linear", Options::Sampling::linear}, {"cubic", Options::Sampling::cubic}},
                     "Interpolation between a photograph's pixels; cubic is sharper"),
      switch_setting("soften", &Options::soften,
                     "Blur photographs in pictures from other directions where the surface is uncertain"),
      switch_setting("soft-edges", &Options::soft_edges,
                     "Blur the picture across depth edges where the nearer surface is uncertain"),
      switch_setting(
          "outlines", &Options::outlines,
          "Continue surfaces past their outlines where they are uncertain, so that photographs show the outline"),
      switch_setting("prefilter", &Options::prefilter,
                     "Sample photographs that were taken from nearer at their coarser levels"),
      number_setting("border-width", &Options::border_width, "SHARE", number_rule(0, 1),
                     "Width over which neighbouring cells fade into each other, as a share of the cell size"),
      choice_setting("antialias", &Options::antialias,
                     {{"silhouettes", Options::Antialias::silhouettes}, {"all", Options::Antialias::all}},
                     "Pixels that --supersample draws as means; all takes N x N + 1 times as long"),
      number_setting("occlusion-tolerance", &Options::occlusion_tolerance, "SHARE", not_negative_rule(),
                     "Share of its depth that a point may lie behind what a photograph sees"),
  };
}

bool has_printed_weights(const BlendOptions& options) {
  BlendOptions printed = BlendOptions::printed();
  printed.views = options.views;
  printed.lambda = options.lambda;
  printed.antialias = options.antialias;
  static const Settings<BlendOptions> table = blend_fields();
  return values_of(table, options) == values_of(table, printed);
}

Setting<BlendOptions> weights_setting() {
  Setting<BlendOptions> row = named_setting<BlendOptions, bool>(
      "weights", {{"ratio", false}, {"printed", true}}, has_printed_weights,
      [](BlendOptions& options, bool printed) {
        if (printed) options = BlendOptions::printed();
      },
      "Formulas of the weights; printed: those of the paper, which set all settings that have a printed value, "
      "--exposure and --supersample");
  row.sets_others = true;
  return row;
}

}  // namespace

Settings<BlendOptions> blend_settings() {
  Settings<BlendOptions> table{weights_setting()};
  for (Setting<BlendOptions>& row : blend_fields()) {
    row.meaning += and_printed(row);
    table.push_back(std::move(row));
  }
  return table;
}

}  // namespace lumatlas
