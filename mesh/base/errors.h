// SPDX-License-Identifier: GPL-3.0-or-later
// The errors that every module throws. Only the program's main() turns one into an exit code.
//
// A broken precondition (the caller's mistake) is a std::invalid_argument that names the field, its value and the rule.
#pragma once

#include <stdexcept>
#include <string>

namespace lumatlas {

// A file or folder that cannot be used. what() is one sentence without a newline: path, index, value, what to do.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace lumatlas
