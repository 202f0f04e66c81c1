// SPDX-License-Identifier: GPL-3.0-or-later
// Rules for the values of options, in plain words that --help prints and complaints repeat. CLI11's own
// rules let NaN through, and infinity where there is no upper bound, read -1 as 2^64 - 1 and 010 as 8, and speak of
// types.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Option.hpp>
#include <CLI/Validators.hpp>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "tools/base/value_rule.h"  // in_words()

namespace lumatlas {

// A whole number from `least` to `most`, in decimal digits alone. Help says "1 to 8", or "2 or more" where the upper
// bound is one that no value reaches, and nothing of 0 or 1 and more.
[[nodiscard]] CLI::Validator whole_number(std::uint64_t least,
                                          std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

// A whole number of at least 1, or one of the `words`.
[[nodiscard]] CLI::Validator count_or(const std::vector<std::string>& words);

// A finite number from `least` to `most`.
[[nodiscard]] CLI::Validator number_between(double least, double most);

// A finite number of 0 or more. Help says nothing of it.
[[nodiscard]] CLI::Validator finite_not_negative();

// A finite number above 0. Help says nothing of it.
[[nodiscard]] CLI::Validator finite_positive();

// The name of a file or folder: not "". Help says nothing of it.
[[nodiscard]] CLI::Validator file_name();

// The name or address of a host: not "", which stands for every address. Help says nothing of it.
[[nodiscard]] CLI::Validator host_name();

// The name of a model to write: a folder's or one that ends in .glb, and not one that ends as what `export` makes of a
// model. Help says nothing of it.
[[nodiscard]] CLI::Validator model_name();

// One of these names.
[[nodiscard]] CLI::Validator one_of(const std::vector<std::string>& names);

// Another word for one of the names: goes with one_of(). Help says nothing of it.
[[nodiscard]] CLI::Validator other_name(const std::string& other, const std::string& name);

// A bound in bytes or in texels.
struct SizeBound {
  std::uint64_t bytes = 0;   // 0: it is not in bytes
  std::uint64_t texels = 0;  // 0: it is not in texels
};

// Reads "512MiB", "300kB", "40Mtexels" or plain bytes; both fields are 0 for text that is no size.
[[nodiscard]] SizeBound size_bound(const std::string& text);

// A size in bytes or in texels, at least 1, or one of the `words`. It stays the text that it is.
[[nodiscard]] CLI::Validator byte_or_texel_size(const std::vector<std::string>& words);

// A size in bytes, at least 1, which is turned into their number.
[[nodiscard]] CLI::Validator byte_size();

// A sentence of the library that names a field of its options, "spacing_px: 2000, must be ..." or "synth: fov_deg is
// 500, must be ...", with the option of that field in its place, "--spacing: 2000, must be ...". `options`: the names
// of the command's options, of which the one that begins as the field does is meant; the sentence stays where none
// does.
[[nodiscard]] std::string with_option_name(const std::string& sentence, const std::vector<std::string>& options);

// The names of an enumeration's values, in the order in which help lists them.
template <typename Value>
using Names = std::vector<std::pair<std::string, Value>>;

template <typename Value>
[[nodiscard]] std::string name_of(const Names<Value>& names, Value value) {
  for (const auto& [name, named] : names) {
    if (named == value) return name;
  }
  return {};
}

// Accepts what `parse` takes without std::invalid_argument, whose sentence is the complaint. Help does not show it.
template <typename Parse>
[[nodiscard]] CLI::Validator parsed_by(Parse parse) {
  return {[parse](std::string& text) -> std::string {
            try {
              (void)parse(text);
            } catch (const std::invalid_argument& error) {
              return error.what();
            }
            return {};
          },
          ""};
}

namespace option_rules {

template <typename Value, typename Target>
CLI::Option* add_named(CLI::App& command, const std::string& option, Target& target, const Names<Value>& names,
                       const std::string& description) {
  std::vector<std::string> words;
  for (const auto& [name, named] : names) words.push_back(name);
  const CLI::callback_t set = [&target, names](const CLI::results_t& given) {
    for (const auto& [name, named] : names) {
      if (name == given.back()) target = named;
    }
    return true;
  };
  return command.add_option(option, set, description)->check(one_of(words))->type_name("NAME");
}

}  // namespace option_rules

// An option whose value is given by name, with the default that `value` has.
template <typename Value>
CLI::Option* add_choice(CLI::App& command, const std::string& option, Value& value,
                        const std::type_identity_t<Names<Value>>& names, const std::string& description) {
  return option_rules::add_named<Value>(command, option, value, names, description)->default_str(name_of(names, value));
}

// Adds an option whose default other options decide; `otherwise` says in help how.
template <typename Value>
CLI::Option* add_choice(CLI::App& command, const std::string& option, std::optional<Value>& value,
                        const std::type_identity_t<Names<Value>>& names, const std::string& description,
                        const std::string& otherwise) {
  return option_rules::add_named<Value>(command, option, value, names, description)->default_str(otherwise);
}

}  // namespace lumatlas
