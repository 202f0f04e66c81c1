// SPDX-License-Identifier: GPL-3.0-or-later
// Shows the progress of a long job on stderr: a bar on a terminal, plain lines elsewhere.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <mutex>
#include <string>

namespace lumatlas {

// Called when a stage of the work begins, with what it is and its number of steps; returns what is called with the
// steps done since the last call, from any thread. What that throws ends the work.
using StageProgress = std::function<std::function<void(std::size_t)>(const std::string& stage, std::size_t steps)>;

struct ProgressOptions {
  using Clock = std::chrono::steady_clock;
  std::ostream* out = nullptr;  // never null in use
  bool is_terminal = false;     // a bar that redraws itself, instead of lines
  bool quiet = false;           // write nothing
  std::size_t columns = 80;     // width of the terminal: the bar's line stays below it
  // Ticks are of work of different kinds, as many for each as it takes time: a percentage instead of count and rate.
  bool as_share = false;
  std::function<Clock::time_point()> now = [] { return Clock::now(); };

  // Called at each tick, from its thread, with the ticks done and their total. What it throws ends the work. Empty: not
  // called.
  std::function<void(std::size_t done, std::size_t total)> told;

  // Returns the options for this process's stderr.
  [[nodiscard]] static ProgressOptions standard_error(bool quiet = false);
};

// Says nothing about work that is done within a second. After that, a terminal shows a bar with rate and remaining
// time, drawn at most ten times a second and replaced by one line at the end; anything else gets a line, then one every
// ten seconds at most, and one at the end. An exception that passes through wipes the bar and ends without a line.
class Progress {
 public:
  // `total`: the ticks to come; 0: unknown. Throws std::invalid_argument if options.out is null.
  Progress(std::string label, std::size_t total, ProgressOptions options = ProgressOptions::standard_error());
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // `count` more are done. From any thread. Throws Interrupted once the user has asked the program to stop.
  void tick(std::size_t count = 1);

 private:
  using Duration = ProgressOptions::Clock::duration;
  [[nodiscard]] Duration elapsed() const { return options_.now() - start_; }
  void draw(Duration at);
  [[nodiscard]] std::string state(std::size_t done, double seconds) const;
  [[nodiscard]] std::string bar_line(std::size_t done, double seconds) const;
  void finish();

  std::string label_;
  std::size_t total_;
  ProgressOptions options_;
  ProgressOptions::Clock::time_point start_;
  int exceptions_at_start_;
  std::atomic<std::size_t> done_{0};
  std::atomic<Duration::rep> next_draw_;
  std::mutex drawing_;
  bool drawn_ = false;
};

}  // namespace lumatlas
