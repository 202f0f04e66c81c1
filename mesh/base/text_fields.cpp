// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/text_fields.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>

namespace lumatlas {

namespace {

std::string_view without_plus(std::string_view field) {
  const bool has_plus = field.size() > 1 && field[0] == '+' && field[1] != '-';
  return has_plus ? field.substr(1) : field;
}

// std::from_chars tells overflow from underflow only by leaving the value alone. A decimal that is out of range either
// has an exponent, whose sign decides, or hundreds of digits, where a leading zero means that it is small.
double out_of_range(std::string_view number) {
  const bool negative = number.starts_with('-');
  if (negative) number.remove_prefix(1);
  const std::size_t exponent = number.find_first_of("eE");
  const bool small = exponent == std::string_view::npos ? number.starts_with('0') || number.starts_with('.')
                                                        : number.substr(exponent + 1).starts_with('-');
  const double magnitude = small ? 0.0 : std::numeric_limits<double>::infinity();
  return negative ? -magnitude : magnitude;
}

}  // namespace

std::string_view take_line(std::string_view& text, char line_feed) {
  const std::size_t length = std::min(text.find(line_feed), text.size());
  const std::string_view line = text.substr(0, length);
  text.remove_prefix(std::min(length + 1, text.size()));
  return line;
}

std::string_view take_field(std::string_view& line, std::string_view separators) {
  line.remove_prefix(std::min(line.find_first_not_of(separators), line.size()));
  const std::size_t length = std::min(line.find_first_of(separators), line.size());
  const std::string_view field = line.substr(0, length);
  line.remove_prefix(length);
  return field;
}

std::optional<double> parse_number(std::string_view field) {
  const std::string_view number = without_plus(field);
  double value = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (end != number.data() + number.size() || error == std::errc::invalid_argument) return {};
  return error == std::errc::result_out_of_range ? out_of_range(number) : value;
}

std::optional<long long> parse_integer(std::string_view field) {
  const std::string_view number = without_plus(field);
  long long value = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (end != number.data() + number.size() || error != std::errc{}) return {};
  return value;
}

std::string in_quotes(std::string_view field) {
  constexpr std::size_t kLongest = 40;  // characters; enough to recognise the place
  std::string text(1, '\'');
  for (const char c : field.substr(0, kLongest)) text += c >= ' ' && c <= '~' ? c : '?';
  if (field.size() > kLongest) text += "...";
  return text += '\'';
}

std::string short_reason(std::string_view reason) {
  constexpr std::size_t kLongest = 200;  // bytes
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  const auto continues = [](char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; };  // a character of UTF-8
  std::size_t length = std::min(reason.size(), kLongest);
  if (length < reason.size()) {
    while (length > 0 && continues(reason[length])) --length;
  }
  std::string text(reason.substr(0, length));
  std::replace_if(text.begin(), text.end(), is_control, ' ');
  text.erase(text.find_last_not_of(' ') + 1);
  return length < reason.size() ? text + "..." : text;
}

}  // namespace lumatlas
