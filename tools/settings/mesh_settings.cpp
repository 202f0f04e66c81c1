// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/settings/option_tables.h"

namespace lumatlas {

Settings<CutOptions> cut_settings() {
  return {
      number_setting("noise", &CutOptions::noise, "SHARE", number_rule(0.001, 100),
                     "With points, their noise in median edges between them: more gives fewer, smoother faces"),
      number_setting("quality", &CutOptions::quality, "WEIGHT", number_rule(0, 1000),
                     "With points or photographs, weight of well-shaped faces against one line of sight"),
      number_setting("sure-views", &CutOptions::sure_views, "N", number_rule(0.1, 1000),
                     "With points or photographs, number of views that a point needs to count for most of its weight")};
}

Settings<SceneMeshOptions> mesh_settings() {
  using Options = SceneMeshOptions;
  return joined<Options>({{whole_setting("mesh.block", &Options::block_px, "PX", whole_number_rule(1, 64),
                                         "With photographs, side of the squares of pixels that give one point each")},
                          within<Options>("cut.", cut_settings(), &Options::cut)});
}

}  // namespace lumatlas
