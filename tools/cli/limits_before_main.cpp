// SPDX-License-Identifier: GPL-3.0-or-later
// Sets up what must hold before anything else runs. The standard streams are open, so that no file that a library opens
// takes their numbers. The limits of the process are high enough: liblog4cplus, which comes with OpenImageIO, starts
// threads as soon as it is loaded and aborts if it cannot, and so does a library that finds no memory.
#include <unistd.h>

#include <string>
#include <string_view>

#include "tools/base/process/process_limits.h"
#include "tools/base/process/standard_streams.h"

namespace {

// `inspect` reads files, and that is all.
std::uint64_t least_address_space(int argument_count, char** arguments) {
  const bool only_reads = argument_count > 1 && std::string_view(arguments[1]) == "inspect";
  return only_reads ? lumatlas::kLeastToRead : lumatlas::kLeastToDraw;
}

void end_with(const std::string& complaint) {
  if (complaint.empty()) return;
  const std::string line = "lumatlas: " + complaint + "\n";
  (void)!write(STDERR_FILENO, line.data(), line.size());
  _exit(1);
}

// Neither exceptions nor the standard library's streams may be used here.
void open_streams_and_refuse_low_limits(int argument_count, char** arguments, char** /*environment*/) {
  end_with(lumatlas::complaint_about_streams());
  end_with(lumatlas::complaint_about_limits(least_address_space(argument_count, arguments)));
}

// The dynamic linker calls what stands in this section of a program before the initialisers of its libraries. The
// sanitizers' own functions are not there yet, so programs that are built with them do without; main() opens their
// streams.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
[[gnu::section(".preinit_array"), gnu::used]] void (*const first_of_all)(int, char**,
                                                                         char**) = open_streams_and_refuse_low_limits;
#else
[[maybe_unused]] void (*const first_of_all)(int, char**, char**) = open_streams_and_refuse_low_limits;
#endif

}  // namespace
