// SPDX-License-Identifier: GPL-3.0-or-later
// Values that Python gives by name.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace lumatlas::python {

// Returns the value of the name. `names`: pairs of a name and a value. Throws std::invalid_argument naming `argument`,
// the name and all that it may be.
template <typename Names>
[[nodiscard]] auto value_named(const Names& names, const std::string& argument, const std::string& name) {
  std::string all;
  std::size_t at = 0;
  for (const auto& [known, value] : names) {
    if (known == name) return value;
    ++at;
    all += (at == 1 ? "" : at == names.size() ? " or " : ", ") + std::string(known);
  }
  throw std::invalid_argument(argument + " is '" + name + "', must be " + all);
}

}  // namespace lumatlas::python
