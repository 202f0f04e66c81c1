// SPDX-License-Identifier: GPL-3.0-or-later
// The program's process: its signals, its streams, and the command line.
#include <exception>
#include <iostream>

#include "mesh/base/freed_memory.h"
#include "tools/base/interrupt.h"
#include "tools/base/standard_streams.h"
#include "tools/cli/command_line.h"

int main(int argc, char** argv) {
  lumatlas::keep_freed_memory();
  lumatlas::install_interrupt_handler();
  try {
    lumatlas::reserve_standard_streams();
    return lumatlas::run_command_line(argc, argv);
  } catch (const lumatlas::Interrupted& interrupted) {
    lumatlas::die_of(interrupted);
  } catch (const std::exception& error) {
    std::cerr << "lumatlas: " << error.what() << '\n';
    return 1;
  }
}
