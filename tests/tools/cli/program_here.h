// SPDX-License-Identifier: GPL-3.0-or-later
// The program's command line without a process of its own: a new one spends a third of a second on loading libraries.
#pragma once

#include "tests/tools/cli/run_program.h"

namespace lumatlas {

// For what ends before any work begins: help and wrong usage. What main() itself does is for lumatlas() to show.
Outcome lumatlas_here(const Arguments& arguments);

}  // namespace lumatlas
