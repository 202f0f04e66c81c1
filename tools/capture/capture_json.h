// SPDX-License-Identifier: GPL-3.0-or-later
// The JSON that `lumatlas capture --json` prints.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "tools/capture/capture.h"

namespace lumatlas {

// Returns an object; tools/cli/README.md lists its keys. `work` and `model`: as they were given to capture().
[[nodiscard]] nlohmann::json capture_json(const CaptureResult& result, const std::filesystem::path& work,
                                          const std::filesystem::path& model);

}  // namespace lumatlas
