// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/settings/option_tables.h"

namespace lumatlas {

Settings<ValidityOptions> mask_settings() {
  using Options = ValidityOptions;
  return {number_setting("depth-edge", &Options::depth_edge, "SHARE", number_rule(1e-9, 1e6),
                         "A depth step counts as an edge above this share of the nearer depth"),
          whole_setting("edge-radius", &Options::edge_radius_px, "PX", whole_number_rule(0, 16),
                        "Pixels this close to a depth edge are masked"),
          whole_setting("fade", &Options::fade_px, "PX", whole_number_rule(0, 16),
                        "Pixels over which a photograph fades at its border and at depth edges"),
          choice_setting("edges", &Options::edges, {kEdgesByName.begin(), kEdgesByName.end()},
                         "Which sides of a depth edge are masked; far shows the nearer side from about where the "
                         "photograph was taken, both is the paper's")};
}

}  // namespace lumatlas
