// SPDX-License-Identifier: GPL-3.0-or-later
// The exception that check() of every options struct throws, and every function that checks its arguments.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"

namespace lumatlas {

// Names the options or the task, the field, its value and the rule that it breaks.
struct Requirement {
  const char* options;

  void operator()(bool holds, const char* field, double value, const char* rule) const {
    if (holds) return;
    throw std::invalid_argument(std::string(options) + ": " + field + " is " + number_text(value) + ", must be " +
                                rule);
  }
  // Requires an index below `count`.
  void is_below(std::size_t index, std::size_t count, const char* field, const char* count_of) const {
    if (index < count) return;
    throw std::invalid_argument(std::string(options) + ": " + field + " is " + std::to_string(index) +
                                ", must be below " + count_of + ", " + std::to_string(count));
  }
  // The size of a list that goes with another.
  void has_size(std::size_t size, std::size_t expected, const char* field, const char* size_of) const {
    if (size == expected) return;
    throw std::invalid_argument(std::string(options) + ": the size of " + field + " is " + std::to_string(size) +
                                ", must be " + size_of + ", " + std::to_string(expected));
  }
};

}  // namespace lumatlas
