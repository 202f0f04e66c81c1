// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tools/cli/program.h"

#include <nlohmann/json.hpp>

namespace lumatlas {

const Made& made() {
  static const Made once;
  return once;
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  return names;
}

nlohmann::json options_beside(const fs::path& output) {
  return nlohmann::json::parse(bytes_of(output / "lumatlas.json"))["options"];
}

}  // namespace lumatlas
