// SPDX-License-Identifier: GPL-3.0-or-later
// Prints the address of the page that a command serves.
#pragma once

#include <string>

namespace lumatlas {

// Prints the address on stdout as a line, or with --json as an object with the key "address", and flushes, because the
// reader waits for it. Throws InputError if it cannot be written, since a page at an unknown address is of no use, and
// Interrupted after SIGPIPE.
void print_address(const std::string& address, bool as_json);

}  // namespace lumatlas
