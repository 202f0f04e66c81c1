// SPDX-License-Identifier: GPL-3.0-or-later
// Settings: fields of option structs that are set by name, "coverage.direction-weight". They are for experiments; what
// users need is an option of a command.
//
// A table has one row for each field of a struct: its name, what it may be, what it means. Parsing, help and the record
// of the values in effect all come from the rows, and a default is what a default-constructed struct holds. Tables of
// nested structs are joined by within():
//
//   const Settings<PlannerOptions> table = within("coverage.", coverage_settings(), &PlannerOptions::coverage);
//   assign(table, options, "coverage.direction-weight", "0.5");
//   values_of(table, options)["coverage.direction-weight"];  // 0.5
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "mesh/base/text_fields.h"
#include "tools/base/value_rule.h"

namespace lumatlas {

template <typename Options>
struct Setting {
  std::string name;        // "direction-weight", with its subject in front where tables are joined
  std::string value_name;  // for the value in help, with its unit: "DEGREES", "NAME"
  std::string meaning;     // for help: what the value does, and when it counts
  ValueRule rule;
  bool sets_others = false;                                    // it gives other rows their values, and is set first
  std::function<void(Options&, const std::string& text)> set;  // the text keeps the rule
  std::function<nlohmann::json(const Options&)> get;           // a number, true, false, or a name
};

template <typename Options>
using Settings = std::vector<Setting<Options>>;

// The names of an enumeration's values, in the order in which help lists them.
template <typename Value>
using SettingNames = std::vector<std::pair<std::string, Value>>;

// A NAME=VALUE that was typed.
struct Assignment {
  std::string name, value;
};

// A row without its struct, for help and for commands.
struct ListedSetting {
  std::string name, value_name, meaning;
  ValueRule rule;
  std::string default_text;
};

// Returns how a value is typed: "0.35", "on", "far".
[[nodiscard]] std::string setting_text(const nlohmann::json& value);

// Returns the sentence for a name that is in no table, with the nearest one that is: "there is no setting blend.view;
// did you mean blend.views?".
[[nodiscard]] std::string no_such_setting(std::string_view name, const std::vector<std::string>& names);

// Returns the row of that name, or null.
template <typename Options>
[[nodiscard]] const Setting<Options>* find_setting(const Settings<Options>& table, std::string_view name) {
  for (const Setting<Options>& row : table) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

template <typename Options>
[[nodiscard]] std::vector<std::string> names_of(const Settings<Options>& table) {
  std::vector<std::string> names;
  for (const Setting<Options>& row : table) names.push_back(row.name);
  return names;
}

// Throws std::invalid_argument, "blend.views: 9 is not a whole number from 1 to 8", and leaves `options` as they are.
template <typename Options>
void assign(const Settings<Options>& table, Options& options, const std::string& name, std::string value) {
  const Setting<Options>* const row = find_setting(table, name);
  if (row == nullptr) throw std::invalid_argument(no_such_setting(name, names_of(table)));
  if (const std::string complaint = row->rule.complaint(value); !complaint.empty()) {
    throw std::invalid_argument(name + ": " + complaint);
  }
  row->set(options, value);
}

// Sets all of them, those first that give others their values. Throws as assign() does, with part of them set.
template <typename Options>
void assign_all(const Settings<Options>& table, Options& options, const std::vector<Assignment>& assignments) {
  for (const bool sets_others : {true, false}) {
    for (const Assignment& one : assignments) {
      const Setting<Options>* const row = find_setting(table, one.name);
      if (row == nullptr || row->sets_others == sets_others) assign(table, options, one.name, one.value);
    }
  }
}

// Returns the values of all rows, by name.
template <typename Options>
[[nodiscard]] nlohmann::json values_of(const Settings<Options>& table, const Options& options) {
  nlohmann::json values = nlohmann::json::object();
  for (const Setting<Options>& row : table) values[row.name] = row.get(options);
  return values;
}

// Sets all rows to the values that values_of() returned, which `values` holds among others. Throws
// std::invalid_argument for a value that a row does not allow, nlohmann::json::exception where one is missing.
template <typename Options>
void assign_values(const Settings<Options>& table, Options& options, const nlohmann::json& values) {
  for (const Setting<Options>& row : table) assign(table, options, row.name, setting_text(values.at(row.name)));
}

// Returns the rows as help lists them; defaults are the values of `defaults`.
template <typename Options>
[[nodiscard]] std::vector<ListedSetting> listed_settings(const Settings<Options>& table, const Options& defaults) {
  std::vector<ListedSetting> rows;
  for (const Setting<Options>& row : table) {
    rows.push_back({row.name, row.value_name, row.meaning, row.rule, setting_text(row.get(defaults))});
  }
  return rows;
}

// Returns the table of a part for the whole that holds it. `part`: a pointer to the member, or a function from the
// whole to a reference to its part, for constant and other wholes.
template <typename Whole, typename Part, typename Find>
void append_within(Settings<Whole>& whole, const std::string& subject, const Settings<Part>& table, Find part) {
  for (const Setting<Part>& row : table) {
    whole.push_back(
        {subject + row.name, row.value_name, row.meaning, row.rule, row.sets_others,
         [set = row.set, part](Whole& options, const std::string& text) { set(std::invoke(part, options), text); },
         [get = row.get, part](const Whole& options) { return get(std::invoke(part, options)); }});
  }
}

template <typename Whole, typename Part, typename Find>
[[nodiscard]] Settings<Whole> within(const std::string& subject, const Settings<Part>& table, Find part) {
  Settings<Whole> whole;
  append_within(whole, subject, table, part);
  return whole;
}

template <typename Options>
[[nodiscard]] Settings<Options> joined(std::vector<Settings<Options>> tables) {
  Settings<Options> all;
  for (Settings<Options>& table : tables) {
    for (Setting<Options>& row : table) all.push_back(std::move(row));
  }
  return all;
}

// A row for a field that is a number.
template <typename Options>
[[nodiscard]] Setting<Options> number_setting(const std::string& name, double Options::*field,
                                              const std::string& value_name, ValueRule rule,
                                              const std::string& meaning) {
  return {name,
          value_name,
          meaning,
          std::move(rule),
          false,
          [field](Options& options, const std::string& text) { options.*field = *parse_number(text); },
          [field](const Options& options) { return options.*field; }};
}

// A row for a field that is a whole number.
template <typename Options, typename Whole>
[[nodiscard]] Setting<Options> whole_setting(const std::string& name, Whole Options::*field,
                                             const std::string& value_name, ValueRule rule,
                                             const std::string& meaning) {
  return {
      name,
      value_name,
      meaning,
      std::move(rule),
      false,
      [field](Options& options, const std::string& text) { options.*field = static_cast<Whole>(std::stoull(text)); },
      [field](const Options& options) { return options.*field; }};
}

// A row whose value is a name; `read` returns the value of the options, `write` sets it.
template <typename Options, typename Value>
[[nodiscard]] Setting<Options> named_setting(const std::string& name, const SettingNames<Value>& names,
                                             std::function<Value(const Options&)> read,
                                             std::function<void(Options&, Value)> write, const std::string& meaning) {
  std::vector<std::string> words;
  for (const auto& [word, value] : names) words.push_back(word);
  return {name,
          "NAME",
          meaning,
          name_rule(words),
          false,
          [names, write](Options& options, const std::string& text) {
            for (const auto& [word, value] : names) {
              if (word == text) write(options, value);
            }
          },
          [names, read](const Options& options) -> nlohmann::json {
            for (const auto& [word, value] : names) {
              if (value == read(options)) return word;
            }
            return nullptr;
          }};
}

// The same for a field.
template <typename Options, typename Value>
[[nodiscard]] Setting<Options> choice_setting(const std::string& name, Value Options::*field,
                                              const std::type_identity_t<SettingNames<Value>>& names,
                                              const std::string& meaning) {
  return named_setting<Options, Value>(
      name, names, [field](const Options& options) { return options.*field; },
      [field](Options& options, Value value) { options.*field = value; }, meaning);
}

// A row that is on or off, for a field; `on`: the field's value for "on".
template <typename Options>
[[nodiscard]] Setting<Options> switch_setting(const std::string& name, bool Options::*field, const std::string& meaning,
                                              bool on = true) {
  return {name,
          "",
          meaning,
          name_rule({"on", "off"}),
          false,
          [field, on](Options& options, const std::string& text) { options.*field = (text == "on") == on; },
          [field, on](const Options& options) { return options.*field == on; }};
}

}  // namespace lumatlas
