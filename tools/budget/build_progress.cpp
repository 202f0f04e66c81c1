// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/build_progress.h"

#include <memory>

#include "tools/base/progress.h"

namespace lumatlas {

namespace {

// The stage that is under way, if any.
struct Shown {
  std::unique_ptr<Progress> progress;
  std::size_t done = 0;
};

}  // namespace

BuildCallback progress_on_standard_error(bool quiet) {
  return [shown = std::make_shared<Shown>(), quiet](const BuildProgress& build) {
    if (build.finished) {
      shown->progress.reset();
    } else if (build.done == 0) {
      shown->progress = std::make_unique<Progress>(build.stage, build.total, ProgressOptions::standard_error(quiet));
      shown->done = 0;
    } else {
      shown->progress->tick(build.done - shown->done);
      shown->done = build.done;
    }
    return true;
  };
}

}  // namespace lumatlas
