// SPDX-License-Identifier: GPL-3.0-or-later
// The options of cells, for every command that makes them.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>
#include <string>

#include "mesh/cells.h"
#include "tools/cli/number_flags.h"

namespace lumatlas {

struct CellFlags {
  double size = 0;
  std::string partition = "clusters";

  void add_to(CLI::App& command) {
    command.add_option("--partition", partition, "How faces are grouped into cells: clusters or grid (the paper's)")
        ->check(CLI::IsMember({"clusters", "grid"}));
    command.add_option("--cell-size", size, "Target diameter of a cell, scene units; 0: 1/60 of the scene")
        ->check(finite_not_negative());
  }

  [[nodiscard]] CellOptions options() const {
    CellOptions options;
    options.partition = partition == "grid" ? Partition::grid : Partition::clusters;
    options.size = size;
    return options;
  }
};

}  // namespace lumatlas
