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

// Returns true if a word stands for what is no number or too large: nan, inf or Infinity, in any case.
bool is_no_number(std::string_view word) {
  std::string lower(word);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower == "nan" || lower == "inf" || lower == "infinity";
}

// Returns the index behind the last letter from `begin` on.
std::size_t end_of_letters(std::string_view text, std::size_t begin) {
  while (begin < text.size() && std::isalpha(static_cast<unsigned char>(text[begin])) != 0) ++begin;
  return begin;
}

// Returns the index behind "(ind)" at `begin`, which C++ writes behind some nan; `begin` if there is no such thing.
std::size_t end_of_payload(std::string_view text, std::size_t begin) {
  if (begin == text.size() || text[begin] != '(') return begin;
  const auto is_of_payload = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  std::size_t end = begin + 1;
  while (end < text.size() && is_of_payload(static_cast<unsigned char>(text[end]))) ++end;
  return end < text.size() && text[end] == ')' ? end + 1 : begin;
}

// Returns the index behind the text in quotes that begins at `begin`.
std::size_t end_of_quoted(std::string_view text, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2 : 1;
  return std::min(end + 1, text.size());
}

}  // namespace

// Looks at each character a bounded number of times, because a file of a gigabyte is as quickly made as one of zeros.
json parse_json_with_nan(std::string_view text, const std::string& file) {
  std::string quoted;
  std::size_t copied = 0;  // the end of what `quoted` has
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] == '"') {
      at = end_of_quoted(text, at);
      continue;
    }
    const bool has_sign = text[at] == '-' || text[at] == '+';
    const std::size_t begin = at + (has_sign ? 1 : 0), end_of_word = end_of_letters(text, begin);
    if (end_of_word == begin || !is_no_number(text.substr(begin, std::min<std::size_t>(end_of_word - begin, 9)))) {
      at = std::max(end_of_word, at + 1);
      continue;
    }
    const std::size_t end = end_of_payload(text, end_of_word);
    quoted.append(text.substr(copied, at - copied)).append(1, '"').append(text.substr(at, end - at)).append(1, '"');
    at = copied = end;
  }
  return parse_json(copied == 0 ? text : std::string_view(quoted.append(text.substr(copied))), file);
}

json parse_json(std::string_view text, const std::string& file) {
  return parsed(
      text, file, [](json::parse_event_t, const json&) {}, false);
}

json read_json(const std::filesystem::path& path) {
  return parse_json(read_whole_file(path), path.string());
}

json read_json_with_comments(const std::filesystem::path& path) {
  std::vector<std::set<std::string>> keys;  // keys of the objects that are open
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
