// SPDX-License-Identifier: GPL-3.0-or-later
// Rules for values that people type as text, told in plain words by help and by complaints.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace lumatlas {

struct ValueRule {
  std::string words;  // what help says of the rule: "0 to 1"; may be empty
  // Returns a complaint, "nan is not a number from 0 to 1", or "" for a value that is allowed. May replace the text by
  // another spelling of the same value.
  std::function<std::string(std::string& text)> complaint;
};

// "one, two or three".
[[nodiscard]] std::string in_words(const std::vector<std::string>& names);

// Returns the shortest text of a number: "0.1", "1e-06".
[[nodiscard]] std::string value_text(double number);

// A whole number from `least` to `most`, in decimal digits alone. The words are "1 to 8", "2 or more" where the upper
// bound is 2^20 or above, and none for 0 or more and 1 or more.
[[nodiscard]] ValueRule whole_number_rule(std::uint64_t least,
                                          std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

// A whole number that `divisor` divides; goes with whole_number_rule().
[[nodiscard]] ValueRule divisible_rule(std::uint32_t divisor);

// A finite number from `least` to `most`.
[[nodiscard]] ValueRule number_rule(double least, double most);

// A finite number of 0 or more, and one above 0. The words are "0 or more" and "above 0".
[[nodiscard]] ValueRule not_negative_rule();
[[nodiscard]] ValueRule positive_rule();

// One of these names.
[[nodiscard]] ValueRule name_rule(const std::vector<std::string>& names);

// Returns a rule that checks both, in this order.
[[nodiscard]] ValueRule both_rules(ValueRule first, ValueRule second);

}  // namespace lumatlas
