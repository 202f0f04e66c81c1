// SPDX-License-Identifier: GPL-3.0-or-later
// A model in the browser while it is built, and afterwards until Ctrl-C.
#pragma once

#include <atomic>
#include <memory>
#include <thread>

#include "tools/cli/flags/build_flags.h"
#include "tools/pipeline/build_model.h"
#include "tools/viewer/live_site.h"

namespace lumatlas {

class ShownBuild {
 public:
  // Starts a server and opens a browser; `flags` must outlive this. With --quiet and without --json the address goes to
  // stdout, otherwise to stderr.
  explicit ShownBuild(const BuildFlags& flags);
  ~ShownBuild();
  ShownBuild(const ShownBuild&) = delete;
  ShownBuild& operator=(const ShownBuild&) = delete;

  // Returns what shows an atlas while it is built.
  [[nodiscard]] AtlasWatch watch();
  // Throws Interrupted.
  void show_until_interrupted(const Snapshot& snapshot);

 private:
  const BuildFlags& flags_;
  SiteServer server_;
  LiveSite site_;
  std::shared_ptr<const Snapshot> snapshot_;  // the last one that was to be shown
  std::atomic<bool> stop_ = false;
  std::thread serving_;
};

}  // namespace lumatlas
