// SPDX-License-Identifier: GPL-3.0-or-later
// How a caller stops long work: by throwing from a function that the work calls every now and then.
#pragma once

#include <functional>

namespace lumatlas {

// Called at least three times a second while the work goes on, from any thread and from several at once. What it throws
// comes out of the call that does the work. An empty function lets the work run to its end.
using InterruptionPoint = std::function<void()>;

inline void may_interrupt(const InterruptionPoint& point) {
  if (point) point();
}

}  // namespace lumatlas
