// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/help_formatter.h"

#include <CLI/Option.hpp>
#include <algorithm>
#include <sstream>
#include <vector>

namespace lumatlas {

namespace {

constexpr std::size_t kColumns = 100;
constexpr std::size_t kTextColumn = 24;  // where descriptions begin

bool is_experiment(const std::string& group) {
  return group.starts_with(kExperiments);
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
std::vector<std::string> placeholder_and_rules(const CLI::Option& option) {
  std::vector<std::string> parts;
  std::istringstream text(option.get_type_name());
  for (std::string part; std::getline(text, part, ':');) parts.push_back(part);
  if (parts.empty()) parts.emplace_back();
  return parts;
}

std::string entry_of(const CLI::Option& option) {
  const bool takes_value = option.get_type_size() != 0;
  const std::vector<std::string> parts = takes_value ? placeholder_and_rules(option) : std::vector<std::string>{""};
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

// What must be given, in the order in which people type it.
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
             placeholder_and_rules(*option).front();
  }
  return usage + " [OPTIONS]\n";
}

std::string help_of_help(const CLI::App& command, const std::string& name, bool has_experiments, bool all) {
  if (!command.get_subcommands({}).empty()) return "\nThe options of a command: " + name + " COMMAND --help\n";
  if (!has_experiments || all) return {};
  return "\nOptions for experiments are listed by: " + name + " --help-all\n";
}

}  // namespace

std::string HelpFormatter::make_help(const CLI::App* command, std::string name, CLI::AppFormatMode mode) const {
  const bool all = mode == CLI::AppFormatMode::All;
  std::string help = command->get_description() + '\n' + usage_of(*command, name);
  for (const CLI::Option* option : positionals_of(*command)) help += entry_of(*option);
  const auto subcommands = command->get_subcommands({});
  if (!subcommands.empty()) help += "\nCommands:\n";
  for (const CLI::App* subcommand : subcommands) help += entry(subcommand->get_name(), subcommand->get_description());
  bool has_experiments = false;
  for (const std::string& group : command->get_groups()) {
    const std::vector<const CLI::Option*> options = options_in(*command, group);
    if (options.empty()) continue;
    has_experiments = has_experiments || is_experiment(group);
    if (is_experiment(group) && !all) continue;
    help += '\n' + group + ":\n";
    for (const CLI::Option* option : options) help += entry_of(*option);
  }
  return help + help_of_help(*command, name, has_experiments, all);
}

void begin_group(CLI::App& command, const std::string& heading) {
  command.option_defaults()->group(heading);
}

void begin_experiments(CLI::App& command, const std::string& subject) {
  begin_group(command, std::string(kExperiments) + ": " + subject);
}

}  // namespace lumatlas
