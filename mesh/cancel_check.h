// SPDX-License-Identifier: GPL-3.0-or-later
// Lets a caller stop long work: it throws from a function that the work calls now and then.
//
//   make_cells(mesh, options, [&] { if (stop_requested) throw Stopped(); });
#pragma once

#include <cstddef>
#include <functional>

namespace lumatlas {

// A cancel check: long work calls it several times a second. What it throws ends the work and comes out of the call
// that does it. An empty function lets the work run to its end. Functions of mesh/ call it on the thread of their
// caller, other work also from several threads at once. Where the number of calls is stated, callers may count them.
using CancelCheck = std::function<void()>;

// Calls a cancel check, if there is one.
inline void check_cancelled(const CancelCheck& cancel_check) {
  if (cancel_check) cancel_check();
}

// Calls a cancel check at every `every`-th of many small steps, so that a step costs next to nothing.
class CancelCheckEvery {
 public:
  CancelCheckEvery(const CancelCheck& cancel_check, std::size_t every) : cancel_check_(cancel_check), every_(every) {}
  void step() {
    if (++steps_ % every_ == 0) check_cancelled(cancel_check_);
  }

 private:
  const CancelCheck& cancel_check_;
  std::size_t every_;  // >= 1
  std::size_t steps_ = 0;
};

}  // namespace lumatlas
