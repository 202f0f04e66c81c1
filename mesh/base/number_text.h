// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers as text for sentences, tables and shaders, the same in every locale.
#pragma once

#include <charconv>
#include <cmath>
#include <concepts>
#include <string>

namespace lumatlas {

// The shortest text that reads back as the same number: "0.1", "1e-07", "100000", "1e+300", "inf", "nan".
// std::to_string() would print 1e-7 as 0.000000, and write a comma where the C locale has one.
template <std::floating_point Number>
[[nodiscard]] std::string number_text(Number number) {
  const Number size = std::abs(number);
  const bool plain = size == 0 || (size >= Number(1e-4) && size < Number(1e15));
  char text[64];
  const std::to_chars_result end = std::to_chars(text, text + sizeof(text), number,
                                                 plain ? std::chars_format::fixed : std::chars_format::scientific);
  return std::string(text, end.ptr);
}

// Returns the number with `decimals` digits behind the point: "0.984808" for 6.
template <std::floating_point Number>
[[nodiscard]] std::string number_text(Number number, int decimals) {
  char text[512];  // the largest double has 309 digits before the point
  const std::to_chars_result end = std::to_chars(text, text + sizeof(text), number, std::chars_format::fixed, decimals);
  return std::string(text, end.ptr);
}

// "34%" for a share of 0.341.
[[nodiscard]] inline std::string percent_text(double share) {
  return number_text(100 * share, 0) + "%";
}

// "640x480".
template <std::integral Count>
[[nodiscard]] std::string size_text(Count width, Count height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace lumatlas
