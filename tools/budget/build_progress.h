// SPDX-License-Identifier: GPL-3.0-or-later
// Lets the caller of build_model() follow a build and stop it.
#pragma once

#include <cstddef>
#include <exception>
#include <functional>
#include <utility>

namespace lumatlas {

// Progress of one stage of a build. Stages come one after the other, each with a call for its start (done is 0),
// one for every step, and one for its end.
struct BuildProgress {
  // "comparing photographs over the mesh", "looking past the mesh", "finding what the mesh lacks", "adding what the
  // mesh lacks", "looking through all cameras", "planning views", "storing views", "planning again", "correcting
  // lenses", "polishing jointly", "measuring what can be given up", "comparing photographs on the surface" or
  // "baking the base texture"
  const char* stage = "";
  std::size_t done = 0;   // steps: cameras, photographs, or rounds over all stored views
  std::size_t total = 0;  // steps; 0: not known beforehand
  bool finished = false;  // this is the call for the stage's end
};

// Called on the thread that called build_model(). Returns whether to go on. If false, build_model() throws
// BuildStopped. An exception from it also ends the build and reaches build_model()'s caller. May be empty.
using BuildCallback = std::function<bool(const BuildProgress&)>;

class BuildStopped : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "the build was stopped by its caller"; }
};

// One stage as it is reported to a callback.
class BuildStage {
 public:
  // Reports the start. `callback` must outlive the stage.
  BuildStage(const BuildCallback& callback, const char* name, std::size_t total)
      : callback_(callback), progress_{name, 0, total, false} {
    report();
  }

  // One more step is done.
  void tick() {
    ++progress_.done;
    report();
  }

  // Reports the end.
  void finish() {
    progress_.finished = true;
    report();
  }

 private:
  void report() {
    if (callback_ && !callback_(std::as_const(progress_))) throw BuildStopped();
  }

  const BuildCallback& callback_;
  BuildProgress progress_;
};

// Shows each stage on stderr as tools/base/progress.h does, and throws Interrupted once the user has asked the program
// to stop (tools/base/process/interrupt.h). `quiet`: shows nothing, but can still be interrupted.
[[nodiscard]] BuildCallback progress_on_standard_error(bool quiet = false);

}  // namespace lumatlas
