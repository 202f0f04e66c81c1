// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/settings/option_tables.h"

namespace lumatlas {

Settings<CellOptions> cell_settings() {
  return {choice_setting("partition", &CellOptions::partition,
                         {{"clusters", Partition::clusters}, {"grid", Partition::grid}},
                         "How faces are grouped into cells; grid is the paper's"),
          number_setting("normal-weight", &CellOptions::normal_weight, "W", not_negative_rule(),
                         "With cells.partition clusters, how strongly a cell avoids turning")};
}

}  // namespace lumatlas
