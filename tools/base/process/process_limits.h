// SPDX-License-Identifier: GPL-3.0-or-later
// The limits of this process: memory, stack and threads. The libraries that draw, trace and read photographs crash,
// abort or hang when they get less than they expect, so the program checks the limits before it uses them.
#pragma once

#include <cstdint>
#include <string>

namespace lumatlas {

// Address space (RLIMIT_AS), bytes: libraries, threads and their heaps, and the scenes and models that were tried; for
// what draws or traces, the driver too.
inline constexpr std::uint64_t kLeastToDraw = std::uint64_t{2} << 30;
inline constexpr std::uint64_t kLeastToRead = std::uint64_t{1} << 30;

// One sentence with the limit, its value and what to do, where the limits are too low; empty where they are not. Too
// low are address space below `least_address_space`, stack (RLIMIT_STACK) below 1 MiB, or fewer threads than
// three for each core and four. The threads are tried: limits of users, containers and services are not all told. Takes
// about a millisecond. May be called before main() and before shared libraries are initialised. What a scene needs
// beyond this shows when its memory is asked for (std::bad_alloc).
[[nodiscard]] std::string complaint_about_limits(std::uint64_t least_address_space);

// Returns a question for the message of a file that could not be written to its end: "is the disk full?". With a limit
// of file size (RLIMIT_FSIZE) it also asks whether that is too low.
[[nodiscard]] std::string why_not_written();

}  // namespace lumatlas
