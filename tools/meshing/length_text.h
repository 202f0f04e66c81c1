// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace lumatlas {

// A length for people, in four significant digits, whatever its size: "0.01235", "1.235e-05".
[[nodiscard]] inline std::string length_text(double length) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", length);
  return text.data();
}

}  // namespace lumatlas
