// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/output/next_steps.h"

#include "tools/base/process/child_process.h"

namespace lumatlas {

std::string next_steps(const std::filesystem::path& model, const std::filesystem::path& scene) {
  std::string lines = "look at it: " + shell_line("lumatlas", {"view", model.string()}) + '\n';
  if (!scene.empty()) {
    lines += "score it:   " + shell_line("lumatlas", {"validate", model.string(), "--views", scene.string()}) + '\n';
  }
  return lines;
}

}  // namespace lumatlas
