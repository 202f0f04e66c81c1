// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/thread_priority.h"

#include <sys/resource.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <thread>

namespace lumatlas {
namespace {

TEST_CASE("a thread lowers its own priority, at most to the lowest, and no other thread's") {
  const int before = getpriority(PRIO_PROCESS, 0);
  int once = 0, often = 0;
  std::thread([&] {
    lower_thread_priority();
    once = getpriority(PRIO_PROCESS, 0);
    for (int i = 0; i < 10; ++i) lower_thread_priority();
    often = getpriority(PRIO_PROCESS, 0);
  }).join();
#ifdef __linux__
  CHECK(once == std::min(before + 5, 19));
  CHECK(often == 19);
#else
  CHECK(often == before);
#endif
  CHECK(getpriority(PRIO_PROCESS, 0) == before);
}

}  // namespace
}  // namespace lumatlas
