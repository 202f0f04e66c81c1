// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/json_output.h"

#include <iostream>
#include <nlohmann/json.hpp>

namespace lumatlas {

void print_json(const nlohmann::json& result) {
  nlohmann::ordered_json versioned;
  versioned["lumatlas"] = LUMATLAS_VERSION;
  for (const auto& [key, value] : result.items()) versioned[key] = value;
  std::cout << versioned.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
}

}  // namespace lumatlas
