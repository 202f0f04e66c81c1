// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/settings/option_tables.h"

namespace lumatlas {

Settings<ColorOptions> color_settings() {
  return {number_setting("sharpness", &ColorOptions::sharpness, "P", number_rule(0, 16),
                         "Exponent by which frontal and near photographs weigh more in the detail"),
          number_setting("tolerance", &ColorOptions::tolerance, "T", number_rule(0.001, 10),
                         "Difference, in square roots of linear light, at which a photograph counts for a quarter")};
}

Settings<ChartOptions> chart_settings() {
  return {number_setting("merge-angle", &ChartOptions::merge_degrees, "DEGREES", number_rule(0, 80),
                         "Largest angle between the normals of a chart and of a cell that joins it"),
          number_setting("most-angle", &ChartOptions::most_degrees, "DEGREES", number_rule(0, 85),
                         "Largest angle under which a chart shows a face, at least charts.merge-angle"),
          number_setting("reach", &ChartOptions::reach, "N", not_negative_rule(),
                         "Most cell sizes between a chart's first cell and a cell that joins it")};
}

Settings<TextureOptions> texture_settings() {
  using Options = TextureOptions;
  const auto layout = [](auto& options) -> auto& {
    return options.layout;
  };
  const Settings<LayoutOptions> gutter{
      whole_setting("gutter", &LayoutOptions::gutter_px, "PX", whole_number_rule(1, 64), "Texels around each chart")};
  return joined<Options>(
      {within<Options>("texture.", gutter, layout),
       {whole_setting("texture.texels-at-once", &Options::most_texels_at_once, "N", whole_number_rule(1),
                      "Texels in memory with --from; beyond them photographs "
                      "are read again")},
       within<Options>("color.", color_settings(), &Options::color),
       within<Options>("charts.", chart_settings(), &Options::charts)});
}

}  // namespace lumatlas
