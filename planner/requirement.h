// SPDX-License-Identifier: GPL-3.0-or-later
// What check() of every options struct throws.
#pragma once

#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"

namespace lumatlas {

// Names the options, the field, its value and the rule that it breaks.
struct Requirement {
  const char* options;

  void operator()(bool holds, const char* field, double value, const char* rule) const {
    if (holds) return;
    throw std::invalid_argument(std::string(options) + ": " + field + " is " + number_text(value) + ", must be " +
                                rule);
  }
};

}  // namespace lumatlas
