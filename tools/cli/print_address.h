// SPDX-License-Identifier: GPL-3.0-or-later
// How a command that serves a page says where.
#pragma once

#include <string>

namespace lumatlas {

// Prints the address on stdout as a line, or with --json as an object with the key "address", and flushes: who reads it
// waits for it. Throws InputError if it cannot be written, for a page whose address nobody learns serves nobody, and
// Interrupted after SIGPIPE.
void print_address(const std::string& address, bool as_json);

}  // namespace lumatlas
