// SPDX-License-Identifier: GPL-3.0-or-later
// The last lines of the commands that make a model: the commands to type next, each after its purpose.
#pragma once

#include <filesystem>
#include <string>

namespace lumatlas {

// One line each, as a shell takes it. `scene` has the photographs that were held out; empty where none were.
[[nodiscard]] std::string next_steps(const std::filesystem::path& model, const std::filesystem::path& scene);

}  // namespace lumatlas
