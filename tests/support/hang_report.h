// SPDX-License-Identifier: GPL-3.0-or-later
// Says where a test program stands that does not end: what CTest ends says nothing of itself.
#pragma once

#include <chrono>

namespace lumatlas {

// Starts a thread that writes write_stacks() to standard error after this time, once. Linux alone.
void report_hang_after(std::chrono::seconds time);

// Writes the stack of each thread of this process, and the command, state and system call of each process below it.
// Addresses are of the program's file: `addr2line -Cfe PROGRAM ADDRESS` names the line. A thread that blocks SIGURG has
// no stack here.
void write_stacks(int descriptor);

}  // namespace lumatlas
