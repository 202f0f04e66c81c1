// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/shown_build.h"

#include <chrono>
#include <iostream>
#include <string>
#include <utility>

#include "tools/base/process/interrupt.h"
#include "tools/cli/output/print_address.h"
#include "tools/viewer/open_browser.h"

namespace lumatlas {

PageOptions page_options_of(const BuildFlags& flags) {
  return {flags.output, flags.server, flags.no_browser, flags.json_output, flags.quiet};
}

ShownBuild::ShownBuild(const PageOptions& options)
    : options_(options), server_(options.server), site_(server_, title_of(options.model)) {
  if (!options.quiet) {
    std::cerr << "see it: " << server_.address() << '\n';
  } else if (!options.json_output) {
    print_address(server_.address(), false);
  }
  if (!options.no_browser) open_browser(server_.address());
  serving_ = std::thread([this] { server_.serve([this] { return stop_.load(); }); });
}

ShownBuild::~ShownBuild() {
  stop_ = true;
  serving_.join();
}

AtlasWatch ShownBuild::watch() {
  return [this](const Atlas& atlas) {
    return follow([&atlas] { return std::make_shared<const Snapshot>(atlas.snapshot()); }, ShowingShare::little);
  };
}

std::shared_ptr<void> ShownBuild::follow(std::function<std::shared_ptr<const Snapshot>()> now, ShowingShare share) {
  return show_while_it_changes(
      site_,
      [this, now = std::move(now)]() -> std::shared_ptr<const Snapshot> {
        std::shared_ptr<const Snapshot> next = now();
        if (!next || (snapshot_ && look_alike(*next, *snapshot_))) return nullptr;
        snapshot_ = next;
        return next;
      },
      share,
      [this](const std::string& why) {
        if (!options_.quiet) std::cerr << "warning: the page is not up to date: " << why << '\n';
      });
}

void ShownBuild::show_until_interrupted(const Snapshot& snapshot) {
  site_.update(snapshot, true, throw_if_interrupted);
  if (!options_.quiet) std::cerr << "the page shows it until Ctrl-C: " << server_.address() << '\n';
  for (;; std::this_thread::sleep_for(std::chrono::milliseconds(50))) throw_if_interrupted();
}

}  // namespace lumatlas
