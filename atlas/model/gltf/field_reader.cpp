// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/gltf/field_reader.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

// Returns a text from a file or a parser fit for a sentence: on one line, and of bounded length.
std::string one_line(std::string text) {
  constexpr std::size_t kLongest = 1000;
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
  std::replace_if(text.begin(), text.end(), is_control, ' ');
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

// RFC 3986, 2.1.
std::string percent_decoded(const std::string& uri) {
  std::string decoded;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const int high = uri[i] == '%' && i + 2 < uri.size() ? hex_digit(uri[i + 1]) : -1;
    const int low = high >= 0 ? hex_digit(uri[i + 2]) : -1;
    decoded.push_back(low >= 0 ? static_cast<char>(16 * high + low) : uri[i]);
    if (low >= 0) i += 2;
  }
  return decoded;
}

}  // namespace

bool has_control_character(const std::string& text) {
  return std::any_of(text.begin(), text.end(), is_control);
}

bool leads_out_of(const fs::path& folder, const fs::path& file) {
  std::error_code error;
  const fs::path home = fs::canonical(folder.empty() ? "." : folder, error);
  if (error) return false;  // opening the file reports the error
  const fs::path place = fs::weakly_canonical(file, error);
  if (error) return false;
  const fs::path relative = place.lexically_relative(home);
  return relative.empty() || *relative.begin() == "..";
}

bool stays_in_folder(const fs::path& relative) {
  return !relative.empty() && relative.is_relative() &&
         std::find(relative.begin(), relative.end(), "..") == relative.end();
}

tinygltf::Value value_of(const nlohmann::json& json) {
  switch (json.type()) {
    case nlohmann::json::value_t::object: {
      tinygltf::Value::Object object;
      for (const auto& [name, part] : json.items()) object.emplace(name, value_of(part));
      return tinygltf::Value(std::move(object));
    }
    case nlohmann::json::value_t::array: {
      tinygltf::Value::Array array;
      for (const nlohmann::json& part : json) array.push_back(value_of(part));
      return tinygltf::Value(std::move(array));
    }
    case nlohmann::json::value_t::string:
      return tinygltf::Value(json.get<std::string>());
    case nlohmann::json::value_t::boolean:
      return tinygltf::Value(json.get<bool>());
    case nlohmann::json::value_t::number_integer:
    case nlohmann::json::value_t::number_unsigned:
    case nlohmann::json::value_t::number_float:
      return tinygltf::Value(json.get<double>());
    default:
      return {};
  }
}

void FieldReader::refuse(const std::string& why) const {
  throw InputError(path_.string() + ": " + one_line(why));
}

const FieldReader::Object& FieldReader::field(const Object& object, const std::string& where, const char* name) const {
  if (!object.IsObject()) refuse(where + " is not an object");
  if (!object.Has(name)) refuse(where + " has no \"" + name + "\"");
  return object.Get(name);
}

void FieldReader::require_within(double x, const std::string& what, double least, double most) const {
  if (x >= least && x <= most) return;
  refuse(what + " is " + number_text(x) + ", must be in [" + number_text(least) + ", " + number_text(most) + "]");
}

double FieldReader::number(const Object& object, const std::string& where, const char* name, double least,
                           double most) const {
  const Object& value = field(object, where, name);
  if (!value.IsNumber()) refuse(where + ": \"" + name + "\" is not a number");
  require_within(value.GetNumberAsDouble(), where + ": \"" + name + "\"", least, most);
  return value.GetNumberAsDouble();
}

std::uint32_t FieldReader::whole_number(const Object& object, const std::string& where, const char* name,
                                        std::uint32_t least, std::uint32_t most) const {
  const double x = number(object, where, name, least, most);
  if (x != std::floor(x)) refuse(where + ": \"" + name + "\" is " + number_text(x) + ", must be a whole number");
  return static_cast<std::uint32_t>(x);
}

std::vector<double> FieldReader::numbers(const Object& object, const std::string& where, const char* name,
                                         std::size_t count) const {
  const Object& array = field(object, where, name);
  if (!array.IsArray() || array.ArrayLen() != count) {
    refuse(where + ": \"" + name + "\" is not an array of " + std::to_string(count) + " numbers");
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) {
    const Object& value = array.Get(static_cast<int>(i));
    if (!value.IsNumber() || !std::isfinite(value.GetNumberAsDouble())) {
      refuse(where + ": \"" + name + "\"[" + std::to_string(i) + "] is not a finite number");
    }
    numbers.push_back(value.GetNumberAsDouble());
  }
  return numbers;
}

std::vector<double> FieldReader::numbers(const Object& object, const std::string& where, const char* name,
                                         std::size_t count, double least, double most) const {
  std::vector<double> all = numbers(object, where, name, count);
  for (std::size_t i = 0; i < count; ++i) {
    require_within(all[i], where + ": \"" + name + "\"[" + std::to_string(i) + "]", least, most);
  }
  return all;
}

std::string FieldReader::text(const Object& object, const std::string& where, const char* name) const {
  const Object& value = field(object, where, name);
  if (!value.IsString()) refuse(where + ": \"" + name + "\" is not a string");
  const auto& text = value.Get<std::string>();
  if (has_control_character(text))
    refuse(where + ": \"" + name + "\" is \"" + text + "\", with a control character in it");
  return text;
}

int FieldReader::accessor(const Object& object, const std::string& where, const char* name) const {
  return static_cast<int>(whole_number(object, where, name, 0, kMostIndex));
}

fs::path FieldReader::file_beside(const std::string& uri, const std::string& where) const {
  if (uri.starts_with("data:")) refuse(where + " is a data URI, must be a file or in a buffer");
  const std::string relative = percent_decoded(uri);
  if (!stays_in_folder(relative) || has_control_character(relative)) {
    refuse(where + " has the path \"" + relative + "\", must lie in the model's own folder");
  }
  fs::path file = path_.parent_path() / relative;
  if (leads_out_of(path_.parent_path(), file)) {
    refuse(where + ", " + relative + ", is a link that leads out of the model's own folder");
  }
  return file;
}

}  // namespace lumatlas
