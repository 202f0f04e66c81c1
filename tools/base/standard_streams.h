// SPDX-License-Identifier: GPL-3.0-or-later
// The three streams that a program is started with, or without.
#pragma once

namespace lumatlas {

// Takes the descriptors 0, 1 and 2 where the program was started without them (`2>&-`), so that no file that it opens
// gets one of these numbers and progress and results are not written into it. Writing to a stream that was taken fails,
// as it does to one that is closed. First thing in main(). Throws std::runtime_error where this cannot be done.
void reserve_standard_streams();

}  // namespace lumatlas
