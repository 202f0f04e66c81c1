// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/flags/option_rules.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <map>
#include <optional>
#include <regex>
#include <system_error>

#include "mesh/base/file_ending.h"
#include "tools/base/value_rule.h"

namespace lumatlas {

namespace {

CLI::Validator validator(const ValueRule& rule) {
  return {rule.complaint, rule.words};
}

// Reads a whole number and its unit; returns none for other text, 0 and numbers above 2^64 - 1.
std::optional<std::uint64_t> scaled(const std::string& text, const std::map<std::string, std::uint64_t>& units) {
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

std::optional<std::uint64_t> bytes_of_size(const std::string& text) {
  static const std::map<std::string, std::uint64_t> units = {
      {"", 1},           {"b", 1},          {"kb", 1000},      {"mb", 1000'000},         {"gb", 1000'000'000},
      {"kib", 1u << 10}, {"mib", 1u << 20}, {"gib", 1u << 30}, {"tb", 1000'000'000'000}, {"tib", 1ull << 40}};
  return scaled(text, units);
}

std::optional<std::uint64_t> texels_of_size(const std::string& text) {
  static const std::map<std::string, std::uint64_t> units = {
      {"texel", 1}, {"ktexel", 1000}, {"mtexel", 1000'000}, {"gtexel", 1000'000'000}};
  return scaled(text, units);
}

constexpr const char* kByteSizes = " is not a size: give bytes, or whole kB, MB, GB or TB, or KiB, MiB, GiB or TiB";

}  // namespace

CLI::Validator whole_number(std::uint64_t least, std::uint64_t most) {
  return validator(whole_number_rule(least, most));
}

CLI::Validator count_or(const std::vector<std::string>& words) {
  const CLI::Validator count = whole_number(1);
  return {[=](std::string& text) -> std::string {
            if (std::find(words.begin(), words.end(), text) != words.end()) return {};
            const std::string complaint = count(text);
            return complaint.empty() ? complaint
                                     : text + " is neither a whole number of 1 or more nor " + in_words(words);
          },
          ""};
}

CLI::Validator number_between(double least, double most) {
  return validator(number_rule(least, most));
}

CLI::Validator finite_not_negative() {
  return validator(not_negative_rule()).description("");
}

CLI::Validator finite_positive() {
  return validator(positive_rule()).description("");
}

CLI::Validator file_name() {
  const auto check = [](std::string& text) { return std::string(text.empty() ? "is empty, must be a name" : ""); };
  return {check, ""};
}

CLI::Validator host_name() {
  const auto check = [](std::string& text) {
    return std::string(text.empty() ? "is empty, must be a name or an address of this machine" : "");
  };
  return {check, ""};
}

CLI::Validator model_name() {
  const auto check = [](std::string& text) -> std::string {
    const std::string ending = lower_case_ending(text);
    for (const auto& [of_export, form] : {std::pair{".obj", "obj"}, {".gltf", "gltf"}, {".html", "web"}}) {
      if (ending != of_export) continue;
      return text + " is not a folder or a .glb, as a model is: make it of a model by lumatlas export MODEL --to " +
             form;
    }
    return {};
  };
  return {check, ""};
}

CLI::Validator one_of(const std::vector<std::string>& names) {
  return validator(name_rule(names));
}

CLI::Validator other_name(const std::string& other, const std::string& name) {
  return CLI::Validator(
      [other, name](std::string& word) {
        if (word == other) word = name;
        return std::string();
      },
      "");
}

SizeBound size_bound(const std::string& text) {
  return {bytes_of_size(text).value_or(0), texels_of_size(text).value_or(0)};
}

CLI::Validator byte_or_texel_size(const std::vector<std::string>& words) {
  const auto check = [words](std::string& text) -> std::string {
    const SizeBound bound = size_bound(text);
    if (bound.bytes > 0 || bound.texels > 0) return {};
    if (std::find(words.begin(), words.end(), text) != words.end()) return {};
    return text + kByteSizes + ", or whole texels, ktexels, Mtexels or Gtexels, or " + in_words(words);
  };
  return {check, ""};
}

CLI::Validator byte_size() {
  const auto to_bytes = [](std::string& text) -> std::string {
    const std::optional<std::uint64_t> bytes = bytes_of_size(text);
    if (!bytes) return text + kByteSizes;
    text = std::to_string(*bytes);
    return {};
  };
  return {to_bytes, ""};
}

std::string with_option_name(const std::string& sentence, const std::vector<std::string>& options) {
  static const std::regex kPattern(R"(^(?:[a-z ]+: )?([a-z_.]+)(?: is |: )([^ ].*)$)");
  std::smatch match;
  if (!std::regex_match(sentence, match, kPattern)) return sentence;
  std::string field = match[1];
  field.erase(0, field.rfind('.') + 1);  // npos + 1 is 0
  std::replace(field.begin(), field.end(), '_', '-');
  std::string meant;
  for (const std::string& option : options) {
    const std::string name = option.substr(std::min<std::size_t>(2, option.size()));
    const bool begins = option.starts_with("--") && (field + '-').starts_with(name + '-');
    if (begins && option.size() > meant.size()) meant = option;
  }
  return meant.empty() ? sentence : meant + ": " + match[2].str();
}

}  // namespace lumatlas
