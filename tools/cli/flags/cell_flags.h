// SPDX-License-Identifier: GPL-3.0-or-later
// --cell-size, for every command that makes cells.
#pragma once

#include <CLI/App.hpp>

#include "mesh/cells/cells.h"
#include "tools/cli/flags/option_rules.h"

namespace lumatlas {

inline CLI::Option* add_cell_size(CLI::App& command, CellOptions& cells) {
  return command.add_option("--cell-size", cells.size, "Diameter of a cell, scene units; 0: 1/60 of the scene's")
      ->type_name("LENGTH")
      ->check(finite_not_negative());
}

}  // namespace lumatlas
