// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/python/progress.h"

#include <atomic>
#include <utility>

namespace lumatlas::python {

namespace py = pybind11;

namespace {

bool truth_of(const py::object& answer) {
  try {
    return answer.cast<bool>();
  } catch (const py::cast_error&) {
    throw py::type_error("progress: has returned a value of type " +
                         py::type::of(answer).attr("__name__").cast<std::string>() +
                         ", must return None, True or False");
  }
}

}  // namespace

Progress::Progress(std::string job, const py::object& progress) : job_(std::move(job)), progress_(progress) {
  if (progress.is_none() || PyCallable_Check(progress.ptr()) != 0) return;
  throw py::type_error("progress: is a value of type " + py::type::of(progress).attr("__name__").cast<std::string>() +
                       ", must be None or a function of stage, done and total");
}

bool Progress::goes_on(const std::string& stage, std::size_t done, std::size_t total) const {
  const py::gil_scoped_acquire locked;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  if (progress_.is_none()) return true;
  const py::object answer = progress_(stage, done, total);
  return answer.is_none() || truth_of(answer);
}

void Progress::tell(const std::string& stage, std::size_t done, std::size_t total) const {
  if (!goes_on(stage, done, total)) throw Stopped(job_);
}

BuildCallback Progress::of_build() const {
  return [this](const BuildProgress& build) {
    tell(build.stage, build.done, build.total);
    return true;
  };
}

StageProgress Progress::of_stages() const {
  return [this](const std::string& stage, std::size_t steps) {
    tell(stage, 0, steps);
    const auto done = std::make_shared<std::atomic<std::size_t>>(0);
    return [this, stage, steps, done](std::size_t more) { tell(stage, done->fetch_add(more) + more, steps); };
  };
}

}  // namespace lumatlas::python
