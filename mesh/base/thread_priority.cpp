// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/thread_priority.h"

#ifdef __linux__
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#endif

namespace lumatlas {

void lower_thread_priority() noexcept {
#ifdef __linux__
  constexpr int kSteps = 5, kLowest = 19;
  // On Linux, the process 0 is the calling thread.
  errno = 0;
  const int now = getpriority(PRIO_PROCESS, 0);
  if (now == -1 && errno != 0) return;
  (void)setpriority(PRIO_PROCESS, 0, std::min(now + kSteps, kLowest));
#endif
}

}  // namespace lumatlas
