// SPDX-License-Identifier: GPL-3.0-or-later
// A model in the browser while it is built, and afterwards until Ctrl-C.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <thread>

#include "tools/cli/flags/build_flags.h"
#include "tools/pipeline/build_model.h"
#include "tools/viewer/live_site.h"

namespace lumatlas {

// Options by which a command shows the model that it makes.
struct PageOptions {
  std::filesystem::path model;  // by which the page is named
  ServerOptions server;
  bool no_browser = false, json_output = false, quiet = false;
};

[[nodiscard]] PageOptions page_options_of(const BuildFlags& flags);

class ShownBuild {
 public:
  // Starts a server and opens a browser. With --quiet and without --json the address goes to stdout, otherwise to
  // stderr.
  explicit ShownBuild(const PageOptions& options);
  ~ShownBuild();
  ShownBuild(const ShownBuild&) = delete;
  ShownBuild& operator=(const ShownBuild&) = delete;

  // Returns what shows an atlas while it is built.
  [[nodiscard]] AtlasWatch watch();
  // Shows what `now` returns, unless it is null, until the returned object is destroyed.
  [[nodiscard]] std::shared_ptr<void> follow(std::function<std::shared_ptr<const Snapshot>()> now, ShowingShare share);
  // Throws Interrupted.
  void show_until_interrupted(const Snapshot& snapshot);

 private:
  PageOptions options_;
  SiteServer server_;
  LiveSite site_;
  std::shared_ptr<const Snapshot> snapshot_;  // the last one that was to be shown
  std::atomic<bool> stop_ = false;
  std::thread serving_;
};

}  // namespace lumatlas
