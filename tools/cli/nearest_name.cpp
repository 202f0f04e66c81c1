// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/nearest_name.h"

#include <algorithm>
#include <numeric>

namespace lumatlas {

namespace {

std::vector<std::string> names_of_commands(const CLI::App& program) {
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

std::vector<std::string> names_of_options(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before_last[j - 2] + 1);
      }
    }
    before_last.swap(last);
    last.swap(row);
  }
  return last[b.size()];
}

std::string nearest_name(std::string_view typed, const std::vector<std::string>& names) {
  constexpr std::size_t kLongest = 100;  // of what is worth comparing
  if (typed.size() > kLongest) return {};
  std::string nearest;
  std::size_t least = std::max<std::size_t>(1, typed.size() / 3) + 1;
  for (const std::string& name : names) {
    const std::size_t distance = edit_distance(typed, name);
    if (distance >= least) continue;
    least = distance;
    nearest = name;
  }
  return nearest;
}

std::string suggestion(const CLI::App& program, int argc, const char* const* argv) {
  const std::vector<const CLI::App*> parsed =
      program.get_subcommands([&](const CLI::App* command) { return program.got_subcommand(command->get_name()); });
  if (parsed.empty()) {
    if (argc < 2 || argv[1][0] == '-') return {};
    const std::string typed = argv[1], command = nearest_name(typed, names_of_commands(program));
    return "There is no command " + typed + (command.empty() ? "." : "; did you mean " + command + "?");
  }
  for (const std::string& extra : program.remaining(true)) {
    if (!extra.starts_with("--")) continue;
    const std::string typed = extra.substr(0, extra.find('='));
    const std::string option = nearest_name(typed, names_of_options(*parsed.front()));
    if (!option.empty()) return "There is no option " + typed + "; did you mean " + option + "?";
  }
  return {};
}

}  // namespace lumatlas
