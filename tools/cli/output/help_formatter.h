// SPDX-License-Identifier: GPL-3.0-or-later
// Formats what --help and --help-all print: a line or two for each option, in its group, at most 100 columns wide, with
// its range and its default in plain words.
#pragma once

#include <CLI/App.hpp>
#include <CLI/FormatterFwd.hpp>
#include <map>
#include <string>
#include <vector>

#include "tools/settings/setting.h"

namespace lumatlas {

// Options whose group begins with these words are listed by --help-all alone. They are accepted like any others.
inline constexpr const char* kRarelyNeeded = "Rarely needed";

class HelpFormatter : public CLI::FormatterBase {
 public:
  // `name` is what was typed before the options: "lumatlas build".
  std::string make_help(const CLI::App* command, std::string name, CLI::AppFormatMode mode) const override;

  std::map<std::string, std::vector<ListedSetting>> settings;  // by command
};

// Options that are added to `command` from here on are listed under this heading.
void begin_group(CLI::App& command, const std::string& heading);

// The same, for options that few people need: --help-all lists them under "Rarely needed: SUBJECT".
void begin_rare_group(CLI::App& command, const std::string& subject);

// Lets --help-all list the settings of a command. Nothing is listed where the command has another formatter.
void list_settings(CLI::App& command, std::vector<ListedSetting> settings);

// Returns those that list_settings() was given.
[[nodiscard]] const std::vector<ListedSetting>& settings_of(const CLI::App& command);

}  // namespace lumatlas
