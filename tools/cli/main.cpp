// SPDX-License-Identifier: GPL-3.0-or-later
// The program's process: its signals, its streams, and the command line.
#include <exception>
#include <iostream>
#include <string>

#include "mesh/base/freed_memory.h"
#include "tools/base/error_sentence.h"
#include "tools/base/process/interrupt.h"
#include "tools/base/process/standard_streams.h"
#include "tools/cli/command_line.h"

int main(int argc, char** argv) {
  // Opens the streams before the first pipe, if limits_before_main.cpp could not.
  if (const std::string complaint = lumatlas::complaint_about_streams(); !complaint.empty()) {
    std::cerr << "lumatlas: " << complaint << '\n';
    return 1;
  }
  lumatlas::keep_freed_memory();
  lumatlas::install_interrupt_handler();
  try {
    return lumatlas::run_command_line(argc, argv);
  } catch (const lumatlas::Interrupted& interrupted) {
    lumatlas::die_of(interrupted);
  } catch (const std::exception& error) {
    std::cerr << "lumatlas: " << lumatlas::error_sentence(error) << '\n';
    return 1;
  }
}
