// SPDX-License-Identifier: GPL-3.0-or-later
// --set NAME=VALUE of the commands whose options have settings: see tools/settings/setting.h.
#pragma once

#include <CLI/App.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/cli/commands.h"
#include "tools/settings/setting.h"

namespace lumatlas {

// The settings that were given by --set.
class GivenSettings {
 public:
  // Adds --set, which takes what `settings` list; --help-all lists them too.
  void add_to(CLI::App& command, std::vector<ListedSetting> settings);

  [[nodiscard]] const std::vector<Assignment>& all() const { return all_; }
  [[nodiscard]] bool has(std::string_view name) const { return value(name).has_value(); }
  [[nodiscard]] std::optional<std::string> value(std::string_view name) const;
  // Throw CLI::ValidationError, "--set cells.partition: is for scenes", if the setting was given, or any whose name
  // begins so; refuse_all(): any.
  void refuse(std::string_view name, const std::string& why) const;
  void refuse_subject(std::string_view subject, const std::string& why) const;
  void refuse_all(const std::string& why) const;

 private:
  std::vector<Assignment> all_;
};

template <typename Options>
class SettingFlags {
 public:
  explicit SettingFlags(Settings<Options> table, Options defaults = {})
      : table_(std::move(table)), defaults_(std::move(defaults)) {}

  void add_to(CLI::App& command) { given_.add_to(command, listed_settings(table_, defaults_)); }

  [[nodiscard]] const GivenSettings& given() const { return given_; }
  [[nodiscard]] const Options& defaults() const { return defaults_; }

  // Sets what was given.
  void apply(Options& options) const { assign_all(table_, options, given_.all()); }

  // Throws CLI::ValidationError for a setting that was given another value than --paper sets; `printed`: the defaults,
  // with what --paper sets.
  void agree_with_paper(const Options& printed) const {
    for (const Assignment& one : given_.all()) {
      const Setting<Options>& row = *find_setting(table_, one.name);
      Options as_given = defaults_;
      row.set(as_given, one.value);
      const nlohmann::json of_paper = row.get(printed);
      if (of_paper == row.get(defaults_) || of_paper == row.get(as_given)) continue;
      throw CLI::ValidationError("--set " + one.name,
                                 "is " + setting_text(of_paper) + " by --paper: leave out one of the two");
    }
  }

  // Returns the values of all settings, for the record beside an output.
  [[nodiscard]] nlohmann::json json(const Options& options) const { return values_of(table_, options); }

 private:
  Settings<Options> table_;
  Options defaults_;
  GivenSettings given_;
};

}  // namespace lumatlas
