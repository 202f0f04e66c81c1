// SPDX-License-Identifier: GPL-3.0-or-later
// How a caller follows long work on a mesh, and stops it.
#pragma once

#include <cstddef>
#include <functional>

namespace lumatlas {

// A cancel check: long work calls it now and then, on the thread that began the work. It may throw, which ends the
// work.
using Tick = std::function<void()>;

// Calls a tick, if there is one, at every `every`-th of many small steps, so that a step costs next to nothing.
class TickEvery {
 public:
  TickEvery(const Tick& tick, std::size_t every) : tick_(tick), every_(every) {}
  void step() {
    if (++steps_ % every_ == 0 && tick_) tick_();
  }

 private:
  const Tick& tick_;
  std::size_t every_;  // >= 1
  std::size_t steps_ = 0;
};

}  // namespace lumatlas
