// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/value_rule.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>
#include <utility>

#include "mesh/base/text_fields.h"

namespace lumatlas {

namespace {

// Help names no upper bound from here on: few users have a million photographs.
constexpr std::uint64_t kNoBoundToName = 1u << 20;

template <typename Holds>
ValueRule rule_of_numbers(const std::string& words, const std::string& wanted, Holds holds) {
  return {words, [wanted, holds](const std::string& text) {
            const std::optional<double> value = parse_number(text);
            return value && holds(*value) ? std::string() : text + " is not " + wanted;
          }};
}

}  // namespace

std::string in_words(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 < names.size() ? ", " : " or ";
    text += names[i];
  }
  return text;
}

std::string value_text(double number) {
  char digits[32];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, number);
  return {digits, end};
}

ValueRule whole_number_rule(std::uint64_t least, std::uint64_t most) {
  const std::string from = std::to_string(least), to = std::to_string(most);
  const auto complaint = [=](std::string& text) -> std::string {
    std::uint64_t number = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc() || stop != end || number < least || number > most) {
      return text + " is not a whole number from " + from + " to " + to;
    }
    text = std::to_string(number);
    return {};
  };
  if (most >= kNoBoundToName) return {least > 1 ? from + " or more" : "", complaint};
  return {from + " to " + to, complaint};
}

ValueRule divisible_rule(std::uint32_t divisor) {
  const std::string words = "a multiple of " + std::to_string(divisor);
  return {words, [=](const std::string& text) {
            std::uint64_t number = 1;
            std::from_chars(text.data(), text.data() + text.size(), number);
            return number % divisor == 0 ? std::string() : text + " is not " + words;
          }};
}

ValueRule number_rule(double least, double most) {
  const std::string range = value_text(least) + " to " + value_text(most);
  return rule_of_numbers(range, "a number from " + range,
                         [=](double value) { return value >= least && value <= most; });
}

ValueRule not_negative_rule() {
  return rule_of_numbers("0 or more", "a finite number of 0 or more",
                         [](double value) { return std::isfinite(value) && value >= 0; });
}

ValueRule positive_rule() {
  return rule_of_numbers("above 0", "a finite number above 0",
                         [](double value) { return std::isfinite(value) && value > 0; });
}

ValueRule name_rule(const std::vector<std::string>& names) {
  return {in_words(names), [names](const std::string& text) {
            const bool known = std::find(names.begin(), names.end(), text) != names.end();
            return known ? std::string() : text + " is not " + in_words(names);
          }};
}

ValueRule both_rules(ValueRule first, ValueRule second) {
  const std::string words = first.words + (first.words.empty() || second.words.empty() ? "" : ", ") + second.words;
  return {words, [first = std::move(first.complaint), second = std::move(second.complaint)](std::string& text) {
            const std::string complaint = first(text);
            return complaint.empty() ? second(text) : complaint;
          }};
}

}  // namespace lumatlas
