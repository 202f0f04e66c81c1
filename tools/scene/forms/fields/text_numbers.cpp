// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/fields/text_numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"

namespace lumatlas {

namespace {

constexpr std::string_view kBlanksInLine = " \t\r\v\f";

}  // namespace

void TextNumbers::skip_blank_lines() {
  while (true) {
    line_.remove_prefix(std::min(line_.find_first_not_of(kBlanksInLine), line_.size()));
    if (!line_.empty() || rest_.empty()) return;
    line_ = take_line(rest_);
    ++number_;
  }
}

bool TextNumbers::at_end() {
  skip_blank_lines();
  return line_.empty();
}

char TextNumbers::next() {
  return at_end() ? '\0' : line_.front();
}

std::string_view TextNumbers::line() {
  skip_blank_lines();
  const std::string_view line = std::exchange(line_, {});
  return line.substr(0, line.find_last_not_of(kBlanksInLine) + 1);
}

std::string_view TextNumbers::field() {
  skip_blank_lines();
  return take_field(line_);
}

double TextNumbers::number(const std::string& what) {
  const std::string_view text = field();
  if (text.empty()) refuse_end(what);
  const std::optional<double> number = parse_number(text);
  if (!number || !std::isfinite(*number)) refuse(what + " is " + in_quotes(text) + ", which is not a finite number");
  return *number;
}

double TextNumbers::number_or_nan(const std::string& what) {
  const std::string_view text = field();
  if (text.empty()) refuse_end(what);
  return parse_number(text).value_or(std::numeric_limits<double>::quiet_NaN());
}

std::uint64_t TextNumbers::count(const std::string& what, std::uint64_t least_bytes) {
  const std::string_view text = field();
  if (text.empty()) refuse_end(what);
  const std::optional<long long> number = parse_integer(text);
  if (!number || *number < 0) refuse(what + " is " + in_quotes(text) + ", which is not a count");
  const auto entries = static_cast<std::uint64_t>(*number);
  const std::uint64_t left = line_.size() + rest_.size() + 1;  // the last entry needs no line end
  if (entries > left / least_bytes) {
    refuse(what + " is " + std::to_string(entries) + ", too many for the " + std::to_string(left - 1) +
           " bytes that follow: the file is damaged or was cut off");
  }
  return entries;
}

void TextNumbers::refuse(const std::string& reason) const {
  throw InputError(path_.string() + ": line " + std::to_string(number_) + ": " + reason);
}

void TextNumbers::refuse_end(const std::string& what) const {
  throw InputError(path_.string() + ": ends before " + what + ": it is damaged or was cut off");
}

}  // namespace lumatlas
