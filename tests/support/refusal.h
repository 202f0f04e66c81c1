// SPDX-License-Identifier: GPL-3.0-or-later
// Returns the message of check() for options that a test has changed.
#pragma once

#include <stdexcept>
#include <string>

namespace lumatlas {

// The complaint, or "accepted".
template <typename Options, typename Change>
std::string refusal(const Change& change) {
  Options options;
  change(options);
  try {
    check(options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace lumatlas
