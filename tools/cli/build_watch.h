// SPDX-License-Identifier: GPL-3.0-or-later
// Messages and the end of `lumatlas build --watch`.
#pragma once

#include <optional>

#include "tools/base/process/interrupt.h"
#include "tools/budget/build_progress.h"
#include "tools/cli/flags/build_flags.h"

namespace lumatlas {

// With --watch, the first Ctrl-C while the program waits for photographs ends the stream, and the model is saved.
// `request` must outlive the build.
void take_end_requests(const BuildFlags& flags, BuildOptions& options, std::optional<EndRequest>& request);

// Progress on stderr, which with --watch says once that Ctrl-C saves the model.
[[nodiscard]] BuildCallback build_progress_of(const BuildFlags& flags);

}  // namespace lumatlas
