// SPDX-License-Identifier: GPL-3.0-or-later
// The built program as a process of its own, under whatever a hostile surrounding gives it.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace lumatlas {

using Arguments = std::vector<std::string>;

// An option of `lumatlas build` that gives the model of a small apartment a tenth of the cells that it has by default.
// Most of the time to build, export and open such a model goes into its cells.
inline const std::string kLargeCells = "--cell-size=0.6";

struct Outcome {
  int status = 0;  // exit status, or minus the signal that ended it
  std::string out;
  std::string err;
};

// The program while it runs, its streams going to files in a folder of its own.
class Run {
 public:
  // `before` is called in the new process just before the program starts: to set limits, close streams, ignore signals.
  explicit Run(Arguments arguments, const std::function<void()>& before = {});
  void send(int signal) const;
  [[nodiscard]] std::string out() const;  // that it has printed so far
  [[nodiscard]] std::string err() const;
  [[nodiscard]] Outcome wait() const;

  // Returns whether the program has ended; wait() still tells how.
  [[nodiscard]] bool has_ended() const;

  // Until `is_so` holds, or the program has had half a minute for it.
  template <typename Condition>
  static void wait_until(const Condition& is_so) {
    for (int wait = 0; wait < 15000 && !is_so(); ++wait) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }

 private:
  TemporaryFolder streams_;
  pid_t child_ = -1;
};

// Runs it to its end. Without `before`, checks that no signal ended it.
Outcome lumatlas(const Arguments& arguments, const std::function<void()>& before = {});

// Checks that it failed with one sentence, which starts as every failure does and has this part.
void check_failure(const Outcome& outcome, const std::string& part);

}  // namespace lumatlas
