// SPDX-License-Identifier: GPL-3.0-or-later
// The main function of all test programs: Catch2's, and an exit code of its own where something was skipped.
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <iostream>

#ifdef __SANITIZE_THREAD__
#include <tbb/global_control.h>
#endif

#include "mesh/base/freed_memory.h"
#include "tests/support/hang_report.h"
#include "tests/support/skip.h"
#include "tests/support/skipped_cases.h"

namespace {

// Reports at nine tenths of the time after which CTest ends this program; tests/CMakeLists.txt hands it over.
void report_hang_before_the_end() {
  if (const char* const seconds = std::getenv("LUMATLAS_TEST_SECONDS")) {
    lumatlas::report_hang_after(std::chrono::seconds(std::atoi(seconds) * 9 / 10));
  }
}

}  // namespace

int main(int argc, char** argv) {
  using namespace lumatlas;
#ifdef __SANITIZE_THREAD__
  // ThreadSanitizer cannot see how TBB's library, which is compiled without it, hands work from one thread to another.
  // So each of our threads does its own work, and what they share among themselves is what is watched.
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
#endif
  keep_freed_memory();
  report_hang_before_the_end();
  const int result = Catch::Session().run(argc, argv);
  for (const SkippedCase& skipped : skipped_cases()) {
    std::cout << "not checked here: " << skipped.name << ": " << skipped.reason << '\n';
  }
  // Catch2 returns the number of failed assertions, which may be any.
  if (result != 0) return result == kSkippedExitCode ? 1 : result;
  return skipped_cases().empty() ? 0 : kSkippedExitCode;
}
