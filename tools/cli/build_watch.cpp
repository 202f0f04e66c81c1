// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/build_watch.h"

#include <iostream>
#include <string_view>
#include <utility>

namespace lumatlas {

void take_end_requests(const BuildFlags& flags, BuildOptions& options, std::optional<EndRequest>& request) {
  if (!options.watch) return;
  options.watch->end = [&request, said = flags.quiet]() mutable {
    if (!request) request.emplace();
    if (!std::exchange(said, true)) std::cerr << "waiting for photographs\n";
    return request->made();
  };
}

BuildCallback build_progress_of(const BuildFlags& flags) {
  BuildCallback progress = progress_on_standard_error(flags.quiet);
  if (!flags.watch || flags.quiet) return progress;
  return [progress = std::move(progress), said = false](const BuildProgress& build) mutable {
    const bool is_first = build.done == 1 && std::string_view(build.stage) == "planning views";
    if (is_first && !std::exchange(said, true)) std::cerr << "the first is there; Ctrl-C saves the model\n";
    return progress(build);
  };
}

}  // namespace lumatlas
