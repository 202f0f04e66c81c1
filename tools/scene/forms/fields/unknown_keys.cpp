// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/fields/unknown_keys.h"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "mesh/base/text_fields.h"

namespace lumatlas {

namespace {

bool is_among(std::string_view key, std::span<const std::string_view> keys) {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

// Returns whether a value is a number other than 0 or holds one, at any depth that parse_json() lets through.
bool holds_a_number(const nlohmann::json& value) {
  if (value.is_number()) return value.get<double>() != 0;
  if (value.is_string()) return parse_number(value.get_ref<const std::string&>()).value_or(0) != 0;
  return value.is_structured() && std::any_of(value.begin(), value.end(), holds_a_number);
}

}  // namespace

void UnknownKeys::look_at(const JsonPlace& object, const std::function<bool(std::string_view key)>& is_known) {
  if (!object.value().is_object()) object.refuse("must be an object");
  for (const auto& [key, value] : object.value().items()) {
    if (!is_known(key)) keys_.insert(key);
  }
}

void UnknownKeys::look_at(const JsonPlace& object, std::span<const std::string_view> known) {
  look_at(object, [known](std::string_view key) { return is_among(key, known); });
}

void UnknownKeys::look_at_lens(const JsonPlace& lens, std::span<const std::string_view> known) {
  look_at(lens, known);
  for (const auto& [key, value] : lens.value().items()) {
    if (is_among(key, known) || !holds_a_number(value)) continue;
    lens.at(key).refuse(
        "is not read of a lens of this kind, and may bend the picture: undistort the photographs first");
  }
}

void UnknownKeys::tell(const std::filesystem::path& path, Capture& capture) const {
  if (keys_.empty()) return;
  constexpr std::size_t kMostNamed = 10;
  std::string names;
  std::size_t named = 0;
  for (const std::string& key : keys_) {
    if (++named > kMostNamed) break;
    names += (names.empty() ? "" : ", ") + short_reason(key);
  }
  const std::string more =
      keys_.size() > kMostNamed ? ", and " + std::to_string(keys_.size() - kMostNamed) + " more" : "";
  capture.notes.push_back(path.filename().string() + " has keys that are not known and not used: " + names + more);
}

}  // namespace lumatlas
