// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/settings/setting.h"

#include <algorithm>

#include "tools/base/nearest_name.h"

namespace lumatlas {

std::string setting_text(const nlohmann::json& value) {
  if (value.is_boolean()) return value.get<bool>() ? "on" : "off";
  if (value.is_string()) return value.get<std::string>();
  return value.is_number_float() ? value_text(value.get<double>()) : value.dump();
}

std::string no_such_setting(std::string_view name, const std::vector<std::string>& names) {
  const std::string sentence = "there is no setting " + std::string(name);
  if (const std::string nearest = nearest_name(name, names); !nearest.empty()) {
    return sentence + "; did you mean " + nearest + "?";
  }
  // The subject is missing, or wrong.
  const std::string field = std::string(name.substr(name.rfind('.') + 1));
  const auto same = std::find_if(names.begin(), names.end(),
                                 [&](const std::string& known) { return known.substr(known.rfind('.') + 1) == field; });
  return sentence + (same == names.end() ? ": --help-all lists them" : "; did you mean " + *same + "?");
}

}  // namespace lumatlas
