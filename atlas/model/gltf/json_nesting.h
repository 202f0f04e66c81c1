// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: how deep the values of a JSON text are nested. Parsers, and code that copies their results, make
// one call a level, so a text of brackets alone could exhaust the stack.
#pragma once

#include <string>

namespace lumatlas {

inline constexpr int kMaxNesting = 64;  // a model nests 6 deep, its notes some more

// Returns how deep arrays and objects of the text lie in one another; 0 for a text without any.
[[nodiscard]] int nesting(const std::string& json);

}  // namespace lumatlas
