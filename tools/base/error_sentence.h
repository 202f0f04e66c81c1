// SPDX-License-Identifier: GPL-3.0-or-later
// The sentences that the program and the Python module print for an exception.
#pragma once

#include <exception>
#include <string>

namespace lumatlas {

// One sentence that is never empty. It names the path and the system's reason where a function of std::filesystem was
// refused, what was asked for where the system has no more memory or threads, and outputs by the name that the user
// gave. Exceptions of this library say what their own sentence says.
[[nodiscard]] std::string error_sentence(const std::exception& error);

}  // namespace lumatlas
