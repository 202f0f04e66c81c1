// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of numbers on the command line: CLI11's own let NaN through, and infinity where there is no upper bound; and
// sizes without a number.
#pragma once

#include <CLI/Validators.hpp>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
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

inline std::optional<std::uint64_t> bytes_of_size(const std::string& text) {
  static const std::map<std::string, std::uint64_t> units = {
      {"", 1},           {"b", 1},          {"kb", 1000},      {"mb", 1000'000},         {"gb", 1000'000'000},
      {"kib", 1u << 10}, {"mib", 1u << 20}, {"gib", 1u << 30}, {"tb", 1000'000'000'000}, {"tib", 1ull << 40}};
  std::uint64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [unit_begin, error] = std::from_chars(text.data(), end, number);
  const auto unit = units.find(CLI::detail::to_lower(std::string(unit_begin, end)));
  if (error != std::errc() || number == 0 || unit == units.end()) return std::nullopt;
  if (number > std::numeric_limits<std::uint64_t>::max() / unit->second) return std::nullopt;
  return number * unit->second;
}

inline std::optional<std::uint64_t> texels_of_size(const std::string& text) {
  static const std::map<std::string, std::uint64_t> units = {
      {"texel", 1}, {"ktexel", 1000}, {"mtexel", 1000'000}, {"gtexel", 1000'000'000}};
  std::uint64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [unit_begin, error] = std::from_chars(text.data(), end, number);
  std::string name = CLI::detail::to_lower(std::string(unit_begin, end));
  if (name.ends_with("texels")) name.pop_back();
  const auto unit = units.find(name);
  if (error != std::errc() || number == 0 || unit == units.end()) return std::nullopt;
  if (number > std::numeric_limits<std::uint64_t>::max() / unit->second) return std::nullopt;
  return number * unit->second;
}

}  // namespace number_flags

// A bound in bytes or in texels.
struct SizeBound {
  std::uint64_t bytes = 0;   // 0: it is not in bytes
  std::uint64_t texels = 0;  // 0: it is not in texels
};

[[nodiscard]] inline SizeBound size_bound(const std::string& text) {
  return {number_flags::bytes_of_size(text).value_or(0), number_flags::texels_of_size(text).value_or(0)};
}

// A size in bytes or in texels, at least 1, which stays the text that it is.
[[nodiscard]] inline CLI::Validator byte_or_texel_size() {
  const auto complaint = [](const std::string& text) -> std::string {
    const SizeBound bound = size_bound(text);
    if (bound.bytes > 0 || bound.texels > 0) return {};
    return text +
           " is not a size: give bytes, or whole kB, MB, GB or TB, or KiB, MiB, GiB or TiB, or whole texels, "
           "ktexels, Mtexels or Gtexels";
  };
  return {complaint, "SIZE"};
}

[[nodiscard]] inline CLI::Validator number_between(double least, double most) {
  std::ostringstream rule;
  rule << "in [" << least << " - " << most << "]";
  return number_flags::validator(rule.str(), [=](double value) { return value >= least && value <= most; });
}

[[nodiscard]] inline CLI::Validator finite_not_negative() {
  return number_flags::validator("finite and >= 0", [](double value) { return std::isfinite(value) && value >= 0; });
}

[[nodiscard]] inline CLI::Validator divisible_by(std::uint32_t divisor) {
  const auto check = [divisor](std::string& text) -> std::string {
    if (std::stoul(text) % divisor == 0) return {};
    return text + " is not a multiple of " + std::to_string(divisor);
  };
  return {check, "MULTIPLE OF " + std::to_string(divisor)};
}

// Turns a size into bytes, at least 1.
[[nodiscard]] inline CLI::Validator byte_size() {
  const auto to_bytes = [](std::string& text) -> std::string {
    const std::optional<std::uint64_t> bytes = number_flags::bytes_of_size(text);
    if (!bytes) return text + " is not a size: give bytes, or whole kB, MB, GB or TB, or KiB, MiB, GiB or TiB";
    text = std::to_string(*bytes);
    return {};
  };
  return {to_bytes, "SIZE"};
}

}  // namespace lumatlas
