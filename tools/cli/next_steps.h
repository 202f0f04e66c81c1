// SPDX-License-Identifier: GPL-3.0-or-later
// What the commands that make a model end with: the lines to type next, each after what it is for.
#pragma once

#include <filesystem>
#include <string>

namespace lumatlas {

// One line each, as a shell takes it. `scene` has the photographs that were held out; empty where none were.
[[nodiscard]] std::string next_steps(const std::filesystem::path& model, const std::filesystem::path& scene);

}  // namespace lumatlas
