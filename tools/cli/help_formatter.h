// SPDX-License-Identifier: GPL-3.0-or-later
// What --help and --help-all print: a line or two for each option, in its group, at most 100 columns wide, with its
// range and its default in plain words.
#pragma once

#include <CLI/App.hpp>
#include <CLI/FormatterFwd.hpp>
#include <string>

namespace lumatlas {

// Options whose group begins with this word are listed by --help-all alone. They are accepted like any others.
inline constexpr const char* kExperiments = "Experiments";

class HelpFormatter : public CLI::FormatterBase {
 public:
  // `name` is what was typed before the options: "lumatlas build".
  std::string make_help(const CLI::App* command, std::string name, CLI::AppFormatMode mode) const override;
};

// Options that are added to `command` from here on are listed under this heading.
void begin_group(CLI::App& command, const std::string& heading);

// The same, for options that few people need: --help-all lists them under "Experiments: SUBJECT".
void begin_experiments(CLI::App& command, const std::string& subject);

}  // namespace lumatlas
