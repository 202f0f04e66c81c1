// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of numbers on the command line: CLI11's own let NaN through, and infinity where there is no upper bound.
#pragma once

#include <CLI/Validators.hpp>
#include <cmath>
#include <sstream>
#include <string>

namespace lumatlas {

namespace number_flags {

template <typename Holds>
CLI::Validator validator(const std::string& rule, Holds holds) {
  const auto complaint = [rule, holds](const std::string& text) {
    double value = 0;
    return CLI::detail::lexical_cast(text, value) && holds(value) ? std::string() : text + " is not " + rule;
  };
  return {complaint, rule};
}

}  // namespace number_flags

[[nodiscard]] inline CLI::Validator number_between(double least, double most) {
  std::ostringstream rule;
  rule << "in [" << least << " - " << most << "]";
  return number_flags::validator(rule.str(), [=](double value) { return value >= least && value <= most; });
}

[[nodiscard]] inline CLI::Validator finite_not_negative() {
  return number_flags::validator("finite and >= 0", [](double value) { return std::isfinite(value) && value >= 0; });
}

}  // namespace lumatlas
