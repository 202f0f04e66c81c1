// SPDX-License-Identifier: GPL-3.0-or-later
// What a command prints on stdout for --json. tools/cli/README.md lists the keys.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace lumatlas {

// Prints an object with the program's version as its first key, "lumatlas". Bytes that are not UTF-8 become U+FFFD.
void print_json(const nlohmann::json& result);

}  // namespace lumatlas
