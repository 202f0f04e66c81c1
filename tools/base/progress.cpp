// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <utility>

#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

constexpr auto kSilence = std::chrono::seconds(1);
constexpr auto kBetweenBars = std::chrono::milliseconds(100);
constexpr auto kBetweenLines = std::chrono::seconds(10);
constexpr std::size_t kWidestBar = 30;
constexpr std::size_t kNarrowestBar = 5;
constexpr const char* kWipe = "\r\x1b[K";

double in_seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

template <typename... Args>
std::string formatted(const char* format, Args... args) {
  char text[64];
  std::snprintf(text, sizeof(text), format, args...);
  return text;
}

std::string rate(double done, double seconds) {
  const double per_second = done / seconds;
  if (per_second >= 10) {
    return formatted("%.0f/s", per_second);
  }
  return per_second >= 1 ? formatted("%.1f/s", per_second) : formatted("%.1f s each", seconds / done);
}

std::string percent(std::size_t done, std::size_t total) {
  return formatted("%.0f %%", total == 0 ? 100.0 : 100.0 * static_cast<double>(done) / static_cast<double>(total));
}

// 0:07, 12:34, 1:02:03
std::string clock_time(double seconds) {
  const auto whole = static_cast<long long>(std::min(seconds, 1e9) + 0.5);
  const long long hours = whole / 3600;
  const long long minutes = whole / 60 % 60;
  return hours > 0 ? formatted("%lld:%02lld:%02lld", hours, minutes, whole % 60)
                   : formatted("%lld:%02lld", minutes, whole % 60);
}

std::string short_time(double seconds) {
  return seconds < 100 ? formatted("%.1f s", seconds) : clock_time(seconds);
}

std::size_t terminal_columns() {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : ProgressOptions{}.columns;
}

}  // namespace

ProgressOptions ProgressOptions::standard_error(bool quiet) {
  ProgressOptions options;
  options.out = &std::cerr;
  options.is_terminal = isatty(STDERR_FILENO) == 1;
  options.quiet = quiet;
  options.columns = terminal_columns();
  return options;
}

Progress::Progress(std::string label, std::size_t total, ProgressOptions options)
    : label_(std::move(label)),
      total_(total),
      options_(std::move(options)),
      exceptions_at_start_(std::uncaught_exceptions()),
      next_draw_(Duration(kSilence).count()) {
  if (options_.out == nullptr) {
    throw std::invalid_argument("progress: out is null, must be a stream");
  }
  start_ = options_.now();
}

Progress::~Progress() {
  try {
    finish();
  } catch (...) {  // NOLINT(bugprone-empty-catch): a stream that cannot be written must not end the program
  }
}

void Progress::tick(std::size_t count) {
  const std::size_t done = done_.fetch_add(count, std::memory_order_relaxed) + count;
  if (!options_.quiet) {
    if (const Duration at = elapsed(); at.count() >= next_draw_.load(std::memory_order_relaxed)) {
      draw(at);
    }
  }
  throw_if_interrupted();
  if (options_.told) options_.told(done, total_);
}

void Progress::draw(Duration at) {
  const std::unique_lock lock(drawing_, std::try_to_lock);
  if (!lock.owns_lock() || at.count() < next_draw_.load(std::memory_order_relaxed)) {
    return;  // another thread is at it, or has just been
  }
  const Duration pause = options_.is_terminal ? Duration(kBetweenBars) : Duration(kBetweenLines);
  next_draw_.store((at + pause).count(), std::memory_order_relaxed);
  const std::size_t done = done_.load(std::memory_order_relaxed);
  if (options_.is_terminal) {
    *options_.out << kWipe << bar_line(done, in_seconds(at)) << std::flush;
  } else {
    *options_.out << label_ << ": " << state(done, in_seconds(at)) << std::endl;
  }
  drawn_ = true;
}

// "120 of 1000, 81/s, 0:11 left", or "12 %, 0:11 left".
std::string Progress::state(std::size_t done, double seconds) const {
  std::string text = options_.as_share ? percent(done, total_) : std::to_string(done);
  if (total_ > 0 && !options_.as_share) {
    text += " of " + std::to_string(total_);
  }
  if (done > 0) {
    if (!options_.as_share) text += ", " + rate(static_cast<double>(done), seconds);
    if (done < total_) {
      text += ", " + clock_time(static_cast<double>(total_ - done) * seconds / static_cast<double>(done)) + " left";
    }
  }
  return text;
}

// "reading photographs [#####-----] 120 of 1000, 81/s, 0:11 left", without the bar where it is too narrow to say much.
// Keeps the line narrower than the terminal, because a line that wraps cannot be wiped.
std::string Progress::bar_line(std::size_t done, double seconds) const {
  const std::string text = state(done, seconds);
  const std::size_t limit = std::max<std::size_t>(options_.columns, 2) - 1;
  const std::size_t taken = label_.size() + text.size() + 4;
  std::string line = label_ + ' ';
  if (total_ > 0 && limit >= taken + kNarrowestBar) {
    const std::size_t width = std::min(kWidestBar, limit - taken);
    const double part = std::min(1.0, static_cast<double>(done) / static_cast<double>(total_));
    const auto filled = static_cast<std::size_t>(part * static_cast<double>(width));
    line += '[' + std::string(filled, '#') + std::string(width - filled, '-') + "] ";
  }
  return (line + text).substr(0, limit);
}

void Progress::finish() {
  const Duration at = elapsed();
  if (options_.quiet || (!drawn_ && at < kSilence)) {
    return;
  }
  if (options_.is_terminal && drawn_) {
    *options_.out << kWipe << std::flush;
  }
  if (std::uncaught_exceptions() > exceptions_at_start_) {
    return;
  }
  const std::size_t done = done_.load(std::memory_order_relaxed);
  const double seconds = in_seconds(at);
  if (options_.as_share) {
    const std::string reached = done < total_ ? percent(done, total_) : "done";
    *options_.out << label_ << ": " << reached << " in " << short_time(seconds) << std::endl;
    return;
  }
  *options_.out << label_ << ": " << done;
  if (done < total_) {
    *options_.out << " of " << total_;
  }
  *options_.out << " in " << short_time(seconds);
  if (done > 0) {
    *options_.out << " (" << rate(static_cast<double>(done), seconds) << ")";
  }
  *options_.out << std::endl;
}

}  // namespace lumatlas
