// SPDX-License-Identifier: GPL-3.0-or-later
// The ending of a file's name, by which forms of files are told.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>

namespace lumatlas {

// Returns the ending with its dot, ASCII letters in lower case: ".jpg" of "a/IMG_1.JPG"; empty where there is none.
[[nodiscard]] inline std::string lower_case_ending(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  std::transform(ending.begin(), ending.end(), ending.begin(), lower);
  return ending;
}

}  // namespace lumatlas
