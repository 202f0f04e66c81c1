// SPDX-License-Identifier: GPL-3.0-or-later
// The options of cells, for every command that makes them.
#pragma once

#include <CLI/App.hpp>

#include "mesh/cells/cells.h"
#include "tools/cli/option_rules.h"

namespace lumatlas {

struct CellFlags {
  CellOptions values;

  void add_size_to(CLI::App& command) {
    command.add_option("--cell-size", values.size, "Diameter of a cell, scene units; 0: 1/60 of the scene's")
        ->type_name("LENGTH")
        ->check(finite_not_negative());
  }

  void add_partition_to(CLI::App& command) {
    add_choice(command, "--partition", values.partition, {{"clusters", Partition::clusters}, {"grid", Partition::grid}},
               "How faces are grouped into cells; grid is the paper's");
  }

  [[nodiscard]] CellOptions options() const { return values; }
};

}  // namespace lumatlas
