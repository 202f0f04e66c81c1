// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/output/suggestion.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <sstream>
#include <vector>

#include "tools/base/nearest_name.h"
#include "tools/cli/output/help_formatter.h"

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

struct Meant {
  std::string text;  // empty: nothing is near
  std::size_t distance = std::numeric_limits<std::size_t>::max();
};

Meant nearest_option(const std::string& typed, const CLI::App& command) {
  const std::string option = nearest_name(typed, names_of_options(command));
  return option.empty() ? Meant() : Meant{option, edit_distance(typed, option)};
}

// "coverage.direction-weight" is meant by --direction-weight and by --coverage-direction-weight.
Meant nearest_setting(const std::string& typed, const std::vector<ListedSetting>& settings) {
  Meant meant;
  for (const ListedSetting& setting : settings) {
    std::string whole = setting.name;
    std::replace(whole.begin(), whole.end(), '.', '-');
    const std::string field = setting.name.substr(setting.name.find('.') + 1);
    for (const std::string& spelling : {"--" + field, "--" + whole}) {
      if (nearest_name(typed, {spelling}).empty()) continue;
      const std::size_t distance = edit_distance(typed, spelling);
      if (distance < meant.distance) meant = {setting.name, distance};
    }
  }
  return meant;
}

std::vector<std::string> words_of(std::string name) {
  constexpr std::size_t kShortest = 4;  // "no", "of" and "max" say little
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '-' || c == '.'; }, ' ');
  std::vector<std::string> words;
  std::istringstream text(name);
  for (std::string word; text >> word;) {
    if (word.size() >= kShortest) words.push_back(word);
  }
  return words;
}

// The setting that shares most words with what was typed: "refinement.lenses" with --keep-lenses.
std::string kindred_setting(const std::string& typed, const std::vector<ListedSetting>& settings) {
  const std::vector<std::string> typed_words = words_of(typed);
  std::string best;
  std::ptrdiff_t most = 0;
  for (const ListedSetting& setting : settings) {
    const std::vector<std::string> words = words_of(setting.name);
    const auto shared = std::count_if(words.begin(), words.end(), [&](const std::string& word) {
      return std::any_of(typed_words.begin(), typed_words.end(),
                         [&](const std::string& other) { return word.starts_with(other); });
    });
    if (shared <= most) continue;
    most = shared;
    best = setting.name;
  }
  return best;
}

std::string meant_by(const std::string& typed, const CLI::App& command) {
  const std::vector<ListedSetting>& settings = settings_of(command);
  const Meant option = nearest_option(typed, command), setting = nearest_setting(typed, settings);
  if (!option.text.empty() && option.distance <= setting.distance) return option.text;
  const std::string name = setting.text.empty() ? kindred_setting(typed, settings) : setting.text;
  return name.empty() ? "" : "--set " + name + "=VALUE";
}

}  // namespace

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
    const std::string meant = meant_by(typed, *parsed.front());
    if (meant.empty()) continue;
    return std::string("There is no option ").append(typed).append("; did you mean ").append(meant).append("?");
  }
  return {};
}

}  // namespace lumatlas
