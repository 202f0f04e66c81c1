// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/strict_json.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"

namespace lumatlas {

using nlohmann::json;

namespace {

bool contains(std::initializer_list<std::string_view> words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string listed(std::initializer_list<std::string_view> words) {
  std::string text;
  for (const std::string_view word : words) text += (text.empty() ? "" : ", ") + std::string(word);
  return text;
}

// "[json.exception.parse_error.101] parse error at line 3, column 5: ..." on one line, without what is in brackets.
std::string reason_of(const json::exception& error) {
  std::string reason = error.what();
  if (const std::size_t start = reason.find("] "); start != std::string::npos) reason.erase(0, start + 2);
  return short_reason(reason);
}

// Shows each event of the parser to `look`, which may throw.
template <typename Look>
json parsed(std::string_view text, const std::string& file, const Look& look, bool comments) {
  const auto watch = [&](int depth, json::parse_event_t event, const json& value) {
    const bool opens = event == json::parse_event_t::object_start || event == json::parse_event_t::array_start;
    if (opens && depth >= kDeepestJson) {
      throw InputError(file + ": has arrays or objects more than " + std::to_string(kDeepestJson) + " deep");
    }
    look(event, value);
    return true;
  };
  try {
    return json::parse(text.begin(), text.end(), watch, true, comments);
  } catch (const json::exception& error) {
    throw InputError(file + ": is not JSON: " + reason_of(error));
  }
}

}  // namespace

void JsonPlace::refuse(const std::string& complaint) const {
  throw InputError(file_ + ": " + (place_.empty() ? "" : place_ + ": ") + complaint);
}

void JsonPlace::expect(bool holds, const char* type) const {
  if (!holds) refuse(std::string("must be ") + type + ", not " + value_->type_name());
}

void JsonPlace::expect_keys(std::initializer_list<std::string_view> required,
                            std::initializer_list<std::string_view> optional) const {
  for (const auto& [key, member] : members()) {
    if (contains(required, key) || contains(optional, key)) continue;
    member.refuse("is not known here: there are " + listed(required) +
                  (optional.size() == 0 ? "" : ", and optionally " + listed(optional)));
  }
  for (const std::string_view key : required) {
    if (!has(key)) refuse("has no \"" + std::string(key) + "\"");
  }
}

bool JsonPlace::has(std::string_view key) const {
  return value_->is_object() && value_->contains(std::string(key));
}

JsonPlace JsonPlace::at(std::string_view key) const {
  const std::string name(key);
  if (!has(key)) refuse("has no \"" + name + "\"");
  return {file_, place_.empty() ? name : place_ + "." + name, value_->at(name)};
}

std::vector<std::pair<std::string, JsonPlace>> JsonPlace::members() const {
  expect(value_->is_object(), "an object");
  std::vector<std::pair<std::string, JsonPlace>> all;
  for (const auto& [key, member] : value_->items()) all.emplace_back(key, at(key));
  return all;
}

std::vector<JsonPlace> JsonPlace::elements() const {
  expect(value_->is_array(), "an array");
  std::vector<JsonPlace> all;
  for (std::size_t i = 0; i < value_->size(); ++i) {
    all.emplace_back(file_, place_ + "[" + std::to_string(i) + "]", (*value_)[i]);
  }
  return all;
}

std::string JsonPlace::text() const {
  expect(value_->is_string(), "a text");
  std::string text = value_->get<std::string>();
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
  if (text.empty() || std::any_of(text.begin(), text.end(), is_control)) refuse("must be a text of one line");
  return text;
}

std::string JsonPlace::one_of(std::initializer_list<std::string_view> words) const {
  std::string word = text();
  if (!contains(words, word)) refuse("is \"" + word + "\", must be one of " + listed(words));
  return word;
}

double JsonPlace::number() const {
  if (value_->is_string()) refuse("is " + value_->dump() + ", must be a number");
  expect(value_->is_number(), "a number");
  const double number = value_->get<double>();
  if (!std::isfinite(number)) refuse("must be a finite number");
  return number;
}

std::size_t JsonPlace::count(std::size_t least, std::size_t most) const {
  if (!value_->is_number_unsigned() || value_->get<std::size_t>() < least || value_->get<std::size_t>() > most) {
    refuse("is " + value_->dump() + ", must be a whole number from " + std::to_string(least) + " to " +
           std::to_string(most));
  }
  return value_->get<std::size_t>();
}

bool JsonPlace::boolean() const {
  expect(value_->is_boolean(), "true or false");
  return value_->get<bool>();
}

namespace {

// The length of what stands at the start of `text` in place of a number that JSON cannot hold: nan, -nan(ind), inf,
// Infinity and the like; 0 if nothing does.
std::size_t no_number_at(std::string_view text) {
  const auto lower = [](unsigned char c) { return static_cast<char>(std::tolower(c)); };
  const std::size_t sign = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
  std::size_t end = sign;
  while (end < text.size() && std::isalpha(static_cast<unsigned char>(text[end]))) ++end;
  std::string word(text.substr(sign, end - sign));
  std::transform(word.begin(), word.end(), word.begin(), lower);
  if (word != "nan" && word != "inf" && word != "infinity") return 0;
  if (end == text.size() || text[end] != '(') return end;
  const std::size_t close = text.find(')', end);
  return close == std::string_view::npos ? end : close + 1;
}

// The length of the text in quotes that stands at the start of `text`, with its quotes.
std::size_t quoted_length(std::string_view text) {
  std::size_t end = 1;
  while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2 : 1;
  return std::min(end + 1, text.size());
}

}  // namespace

json parse_json_with_nan(std::string_view text, const std::string& file) {
  std::string quoted;
  while (!text.empty()) {
    const bool is_quote = text.front() == '"';
    const std::size_t no_number = is_quote ? 0 : no_number_at(text);
    const std::size_t length = is_quote ? quoted_length(text) : std::max<std::size_t>(no_number, 1);
    const std::string_view taken = text.substr(0, length);
    quoted += no_number > 0 ? '"' + std::string(taken) + '"' : std::string(taken);
    text.remove_prefix(length);
  }
  return parse_json(quoted, file);
}

json parse_json(std::string_view text, const std::string& file) {
  return parsed(
      text, file, [](json::parse_event_t, const json&) {}, false);
}

json read_json(const std::filesystem::path& path) {
  return parse_json(read_whole_file(path), path.string());
}

json read_json_with_comments(const std::filesystem::path& path) {
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  const auto refuse_repetition = [&](json::parse_event_t event, const json& value) {
    if (event == json::parse_event_t::object_start) keys.emplace_back();
    if (event == json::parse_event_t::object_end) keys.pop_back();
    if (event == json::parse_event_t::key && !keys.back().insert(value.get<std::string>()).second) {
      throw InputError(path.string() + ": has \"" + value.get<std::string>() + "\" twice in one object");
    }
  };
  return parsed(read_whole_file(path), path.string(), refuse_repetition, true);
}

}  // namespace lumatlas
