// SPDX-License-Identifier: GPL-3.0-or-later
// The three streams that a program is started with, or without.
#pragma once

#include <string>

namespace lumatlas {

// Takes the descriptors 0, 1 and 2 if the program was started without them (`2>&-`). Otherwise a file, pipe or socket
// of the program or its libraries would get one of these numbers, and progress and results would be written into it.
// Writing to a stream that was taken fails, as it does to one that is closed. Must be called before anything else opens
// a file: before main() and before shared libraries are initialised. Returns one sentence where a descriptor cannot be
// taken, and an empty text where all three are open.
[[nodiscard]] std::string complaint_about_streams();

}  // namespace lumatlas
