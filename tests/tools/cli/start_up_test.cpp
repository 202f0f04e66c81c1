// SPDX-License-Identifier: GPL-3.0-or-later
// Tests which libraries the program loads at its start.
#include <algorithm>
#include <catch2/catch.hpp>
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

}  // namespace
}  // namespace lumatlas
