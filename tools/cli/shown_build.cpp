// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/shown_build.h"

#include <chrono>
#include <iostream>
#include <string>

#include "tools/base/process/interrupt.h"
#include "tools/cli/output/print_address.h"
#include "tools/viewer/open_browser.h"

namespace lumatlas {

ShownBuild::ShownBuild(const BuildFlags& flags)
    : flags_(flags), server_(flags.server), site_(server_, title_of(flags.output)) {
  if (!flags.quiet) {
    std::cerr << "see it: " << server_.address() << '\n';
  } else if (!flags.json_output) {
    print_address(server_.address(), false);
  }
  if (!flags.no_browser) open_browser(server_.address());
  serving_ = std::thread([this] { server_.serve([this] { return stop_.load(); }); });
}

ShownBuild::~ShownBuild() {
  stop_ = true;
  serving_.join();
}

AtlasWatch ShownBuild::watch() {
  return [this](const Atlas& atlas) {
    return show_while_it_changes(
        site_,
        [this, &atlas]() -> std::shared_ptr<const Snapshot> {
          auto next = std::make_shared<const Snapshot>(atlas.snapshot());
          if (snapshot_ && look_alike(*next, *snapshot_)) return nullptr;
          snapshot_ = next;
          return next;
        },
        [this](const std::string& why) {
          if (!flags_.quiet) std::cerr << "warning: the page is not up to date: " << why << '\n';
        });
  };
}

void ShownBuild::show_until_interrupted(const Snapshot& snapshot) {
  site_.update(snapshot, true, throw_if_interrupted);
  if (!flags_.quiet) std::cerr << "the page shows it until Ctrl-C: " << server_.address() << '\n';
  for (;; std::this_thread::sleep_for(std::chrono::milliseconds(50))) throw_if_interrupted();
}

}  // namespace lumatlas
