// SPDX-License-Identifier: GPL-3.0-or-later
// Helpers for the sentences with which readers and writers refuse an image.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>

namespace lumatlas {

inline constexpr int kLongestImageSide = 65536;  // pixels; also the largest camera

// Returns OpenImageIO's first reason in brackets. It does not always give one, and it may give one for each row.
[[nodiscard]] inline std::string because(std::string reason) {
  reason.resize(std::min(reason.size(), reason.find('\n')));
  while (!reason.empty() && std::isspace(static_cast<unsigned char>(reason.back()))) reason.pop_back();
  return reason.empty() ? reason : " (" + reason + ")";
}

}  // namespace lumatlas
