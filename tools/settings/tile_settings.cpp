// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

void set_whole_views(TileOptions& options, bool whole_views) {
  if (whole_views) {
    options.tile_px = 0;
  } else if (options.whole_views()) {
    options.tile_px = TileOptions{}.tile_px;
  }
}

}  // namespace

Settings<TileOptions> tile_settings() {
  using Options = TileOptions;
  Setting<Options> gutter =
      whole_setting("gutter", &Options::gutter_px, "PX", name_rule({"1", "2", "4", "8"}),
                    "Pixels around a tile that are kept with it; 1, 2, 4 or 8 allow 0, 1, 2 or 3 coarser levels, with "
                    "tiles.texels bc7 one fewer; with bc7 4 unless given");
  return {
      named_setting<Options, bool>(
          "layout", {{"tiles", false}, {"layers", true}}, [](const Options& options) { return options.whole_views(); },
          set_whole_views, "Keep the parts of photographs that cells refer to, or whole photographs"),
      whole_setting("tile", &Options::tile_px, "PX", both_rules(whole_number_rule(8, 1024), divisible_rule(8)),
                    "With tiles.layout tiles, side of a tile"),
      gutter};
}

}  // namespace lumatlas
