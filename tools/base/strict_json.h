// SPDX-License-Identifier: GPL-3.0-or-later
// Reads JSON files of unknown origin safely, and JSON that people write strictly. In the latter, comments are allowed,
// but an unknown or repeated key, a missing one and a wrong type are refused by file and place ("sweep.json:
// series[2].build.cell-sise: ...").
#pragma once

#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lumatlas {

// A value of a JSON file and where it stands. Refers to the value, which must outlive it. All functions throw
// InputError, one sentence with file and place, where the value is not what they are asked for.
class JsonPlace {
 public:
  JsonPlace(std::string file, std::string place, const nlohmann::json& value)
      : file_(std::move(file)), place_(std::move(place)), value_(&value) {}

  [[noreturn]] void refuse(const std::string& complaint) const;

  [[nodiscard]] const nlohmann::json& value() const { return *value_; }
  // The same place with another value, which must outlive it.
  [[nodiscard]] JsonPlace with(const nlohmann::json& value) const { return {file_, place_, value}; }
  // The value must be an object. Refuses keys that are not named here, and the absence of the required ones.
  void expect_keys(std::initializer_list<std::string_view> required,
                   std::initializer_list<std::string_view> optional) const;
  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] JsonPlace at(std::string_view key) const;                        // requires an object that has the key
  [[nodiscard]] std::vector<std::pair<std::string, JsonPlace>> members() const;  // an object's, sorted by name
  [[nodiscard]] std::vector<JsonPlace> elements() const;                         // an array's
  [[nodiscard]] std::string text() const;                                        // not empty, one line
  [[nodiscard]] std::string one_of(std::initializer_list<std::string_view> words) const;
  [[nodiscard]] double number() const;                                         // finite
  [[nodiscard]] std::size_t count(std::size_t least, std::size_t most) const;  // a whole number between these
  [[nodiscard]] bool boolean() const;

 private:
  void expect(bool holds, const char* type) const;

  std::string file_, place_;
  const nlohmann::json* value_;
};

// Maximum nesting of arrays and objects. Code that walks through values calls itself once a level.
inline constexpr int kDeepestJson = 100;

// The value that `text` is, which `file` names in sentences. Throws InputError where it is not JSON, or deeper than
// kDeepestJson. Every JSON text that this process did not write itself comes through here.
[[nodiscard]] nlohmann::json parse_json(std::string_view text, const std::string& file);

// Like parse_json(), for a text in which numbers may be nan or inf, as Python and C++ write them. These become texts
// such as "NaN", so that JsonPlace::number() refuses them with their place.
[[nodiscard]] nlohmann::json parse_json_with_nan(std::string_view text, const std::string& file);

// A file's value. Throws InputError as read_whole_file() and parse_json() do; the second also where a key is repeated.
[[nodiscard]] nlohmann::json read_json(const std::filesystem::path& path);
[[nodiscard]] nlohmann::json read_json_with_comments(const std::filesystem::path& path);

}  // namespace lumatlas
