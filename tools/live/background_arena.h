// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/live/: where the threads of a LiveModel run their loops, so that offer() does not wait for them.
#pragma once

#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>

#include "mesh/base/thread_priority.h"

namespace lumatlas {

// Runs work at low priority: the thread that calls run(), and the threads of the pool that help it. The pool's threads
// stay at low priority afterwards, also where they help other work of the process.
class BackgroundArena {
 public:
  template <typename Run>
  void run(const Run& work) {
    lower_thread_priority();
    arena_.execute(work);
  }

 private:
  class Observer : public tbb::task_scheduler_observer {
   public:
    explicit Observer(tbb::task_arena& arena) : tbb::task_scheduler_observer(arena) { observe(true); }
    ~Observer() override { observe(false); }
    Observer(const Observer&) = delete;
    Observer& operator=(const Observer&) = delete;
    void on_scheduler_entry(bool is_worker) override {
      thread_local bool lowered = false;
      if (is_worker && !lowered) lower_thread_priority();
      lowered = lowered || is_worker;
    }
  };

  tbb::task_arena arena_;
  Observer observer_{arena_};
};

// Runs work on the calling thread alone: no part of it is on a thread that has to give way to others.
template <typename Run>
auto run_alone(const Run& work) {
  tbb::task_arena alone(1);
  return alone.execute(work);
}

}  // namespace lumatlas
