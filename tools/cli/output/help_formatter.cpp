// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/output/help_formatter.h"

#include <CLI/Option.hpp>
#include <algorithm>
#include <memory>
#include <sstream>
#include <utility>
#include <vector>

namespace lumatlas {

namespace {

constexpr std::size_t kColumns = 100;
constexpr std::size_t kTextColumn = 24;  // where descriptions begin

bool is_rare(const std::string& group) {
  return group.starts_with(kRarelyNeeded);
}

// `head`, and `text` beside it from kTextColumn on, broken at spaces. A head that is too long has a line of its own.
std::string entry(const std::string& head, const std::string& text) {
  std::string out = "  " + head;
  std::size_t column = out.size();
  const auto begin_line = [&] {
    out += '\n' + std::string(kTextColumn, ' ');
    column = kTextColumn;
  };
  if (column + 2 > kTextColumn) {
    begin_line();
  } else {
    out.append(kTextColumn - column, ' ');
    column = kTextColumn;
  }
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const bool is_first = column == kTextColumn;
    if (!is_first && column + 1 + word.size() > kColumns) begin_line();
    if (column > kTextColumn) out += ' ';
    column += word.size() + (column > kTextColumn ? 1 : 0);
    out += word;
  }
  return out + '\n';
}

// CLI11 joins what stands for the value and the words of each rule by colons: "N:1 to 8".
std::vector<std::string> value_name_and_rules(const CLI::Option& option) {
  std::vector<std::string> parts;
  std::istringstream text(option.get_type_name());
  for (std::string part; std::getline(text, part, ':');) parts.push_back(part);
  if (parts.empty()) parts.emplace_back();
  return parts;
}

std::string entry_of(const CLI::Option& option) {
  const bool takes_value = option.get_type_size() != 0;
  const std::vector<std::string> parts = takes_value ? value_name_and_rules(option) : std::vector<std::string>{""};
  std::string head = option.get_positional() ? option.get_name(true) : option.get_name(false, true);
  if (const std::size_t comma = head.find(','); comma != std::string::npos) head.insert(comma + 1, " ");
  if (!option.get_positional() && !parts.front().empty()) head += " " + parts.front();
  std::string limits;
  for (std::size_t i = 1; i < parts.size(); ++i) limits += (limits.empty() ? "" : ", ") + parts[i];
  if (takes_value && !option.get_default_str().empty()) {
    limits += (limits.empty() ? "default " : "; default ") + option.get_default_str();
  }
  return entry(head, option.get_description() + (limits.empty() ? "" : " (" + limits + ")"));
}

bool is_for_help(const CLI::App& command, const CLI::Option* option) {
  return option == command.get_help_ptr() || option == command.get_help_all_ptr();
}

std::vector<const CLI::Option*> options_in(const CLI::App& command, const std::string& group) {
  return command.get_options([&](const CLI::Option* option) {
    return option->get_group() == group && !option->get_positional() && !is_for_help(command, option);
  });
}

std::vector<const CLI::Option*> positionals_of(const CLI::App& command) {
  return command.get_options([](const CLI::Option* option) { return option->get_positional(); });
}

// Returns the usage line: what must be given, in the order in which people type it.
std::string usage_of(const CLI::App& command, const std::string& name) {
  std::string usage = "Usage: " + name;
  const auto subcommands = command.get_subcommands({});
  if (!subcommands.empty()) usage += " COMMAND";
  for (const CLI::Option* option : positionals_of(command)) {
    usage += " " + option->get_name(true) + (option->get_expected_max() > 1 ? "..." : "");
  }
  const auto required = command.get_options(
      [](const CLI::Option* option) { return option->get_required() && !option->get_positional(); });
  for (const CLI::Option* option : required) {
    const std::string letter = option->get_snames().empty() ? "" : "-" + option->get_snames().front();
    usage += " " + (letter.empty() ? "--" + option->get_lnames().front() : letter) + " " +
             value_name_and_rules(*option).front();
  }
  return usage + " [OPTIONS]\n";
}

std::string entry_of(const ListedSetting& setting) {
  const std::string head = setting.name + (setting.value_name.empty() ? "" : " " + setting.value_name);
  const std::string limits = setting.rule.words + (setting.rule.words.empty() ? "" : "; ");
  return entry(head, setting.meaning + " (" + limits + "default " + setting.default_text + ")");
}

std::string settings_text(const CLI::App& command) {
  std::string text;
  for (const ListedSetting& setting : settings_of(command)) text += entry_of(setting);
  return text.empty() ? text : "\nSettings for experiments, each by --set NAME=VALUE:\n" + text;
}

std::string help_of_help(const CLI::App& command, const std::string& name, bool has_more, bool all) {
  if (!command.get_subcommands({}).empty()) return "\nThe options of a command: " + name + " COMMAND --help\n";
  if (!has_more || all) return {};
  return "\nWhat is rarely needed, and settings for experiments: " + name + " --help-all\n";
}

}  // namespace

std::string HelpFormatter::make_help(const CLI::App* command, std::string name, CLI::AppFormatMode mode) const {
  const bool all = mode == CLI::AppFormatMode::All;
  std::string help = command->get_description() + '\n' + usage_of(*command, name);
  for (const CLI::Option* option : positionals_of(*command)) help += entry_of(*option);
  const auto subcommands = command->get_subcommands({});
  if (!subcommands.empty()) help += "\nCommands:\n";
  for (const CLI::App* subcommand : subcommands) help += entry(subcommand->get_name(), subcommand->get_description());
  bool has_more = false;
  for (const std::string& group : command->get_groups()) {
    const std::vector<const CLI::Option*> options = options_in(*command, group);
    if (options.empty()) continue;
    has_more = has_more || is_rare(group);
    if (is_rare(group) && !all) continue;
    help += '\n' + group + ":\n";
    for (const CLI::Option* option : options) help += entry_of(*option);
  }
  if (all) help += settings_text(*command);
  return help + help_of_help(*command, name, has_more, all);
}

void begin_group(CLI::App& command, const std::string& heading) {
  command.option_defaults()->group(heading);
}

void begin_rare_group(CLI::App& command, const std::string& subject) {
  begin_group(command, std::string(kRarelyNeeded) + ": " + subject);
}

void list_settings(CLI::App& command, std::vector<ListedSetting> settings) {
  const auto formatter = std::dynamic_pointer_cast<HelpFormatter>(command.get_formatter());
  if (formatter) formatter->settings[command.get_name()] = std::move(settings);
}

const std::vector<ListedSetting>& settings_of(const CLI::App& command) {
  static const std::vector<ListedSetting> none;
  const auto formatter = std::dynamic_pointer_cast<const HelpFormatter>(command.get_formatter());
  if (!formatter) return none;
  const auto found = formatter->settings.find(command.get_name());
  return found == formatter->settings.end() ? none : found->second;
}

}  // namespace lumatlas
