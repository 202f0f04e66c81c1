// SPDX-License-Identifier: GPL-3.0-or-later
// Tests which libraries the program loads at its start, and that a signal ends it however early.
#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>

#include "tests/tools/cli/run_program.h"

namespace lumatlas {
namespace {

// The dynamic linker then lists what it loads instead of starting the program.
void list_libraries() {
  setenv("LD_TRACE_LOADED_OBJECTS", "1", 1);
}

TEST_CASE("the program starts without the libraries for images") {
  const Outcome libraries = lumatlas({"--version"}, list_libraries);
  CHECK(libraries.out.find("libstdc++.so") != std::string::npos);
  for (const char* const late : {"libOpenImageIO.so", "libheif.so", "libraw", "libhdf5", "libgdal"}) {
    CAPTURE(late);
    CHECK(libraries.out.find(late) == std::string::npos);
  }
  // Each library costs some tenth of a millisecond, and there were 270 with those for images.
  CHECK(std::count(libraries.out.begin(), libraries.out.end(), '\n') <= 60);
}

TEST_CASE("a signal ends the program even where it comes before its first instruction") {
  for (int start = 0; start < 100; ++start) {
    const Run run({"--version"});
    run.send(SIGINT);
    const int status = run.wait().status;
    if (status != 0) CHECK(status == -SIGINT);  // 0: it was done before
  }
}

}  // namespace
}  // namespace lumatlas
