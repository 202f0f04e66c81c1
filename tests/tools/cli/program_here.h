// SPDX-License-Identifier: GPL-3.0-or-later
// The program's command line without a process of its own: a new one spends a third of a second on loading libraries.
#pragma once

#include "tests/tools/cli/run_program.h"

namespace lumatlas {

// For what no process is needed: lumatlas() is for signals, for what main() itself does, and for a program that starts
// itself again.
Outcome lumatlas_here(const Arguments& arguments);

}  // namespace lumatlas
