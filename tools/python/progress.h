// SPDX-License-Identifier: GPL-3.0-or-later
// Lets a Python callable `progress(stage, done, total)` follow a job and end it.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <string>

#include "tools/base/progress.h"
#include "tools/budget/build_progress.h"

namespace lumatlas::python {

// A job that ended because `progress` returned False.
class Stopped : public std::exception {
 public:
  explicit Stopped(const std::string& job) : sentence_("the " + job + " was stopped by its caller") {}
  [[nodiscard]] const char* what() const noexcept override { return sentence_.c_str(); }

 private:
  std::string sentence_;
};

// Python's `progress`, which may be None. It is made, and destroyed, with Python's lock; its functions take the lock
// themselves and may be called from any thread. All of them throw what Python throws, KeyboardInterrupt at Ctrl-C too.
class Progress {
 public:
  // `job`: what Stopped calls it.
  Progress(std::string job, const pybind11::object& progress);

  // Throws Stopped where `progress` returns False, pybind11::type_error for what is neither None nor a truth value.
  void tell(const std::string& stage, std::size_t done, std::size_t total) const;

  // The same as callbacks of the library. They hold no reference of Python's: this must outlive them.
  [[nodiscard]] BuildCallback of_build() const;
  [[nodiscard]] StageProgress of_stages() const;

 private:
  [[nodiscard]] bool goes_on(const std::string& stage, std::size_t done, std::size_t total) const;

  std::string job_;
  pybind11::object progress_;
};

}  // namespace lumatlas::python
