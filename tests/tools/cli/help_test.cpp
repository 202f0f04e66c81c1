// SPDX-License-Identifier: GPL-3.0-or-later
// Help that people read: a screen for each command, in plain words.
#include <catch2/catch.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"

namespace lumatlas {
namespace {

const std::vector<std::string> kCommands{"capture",  "inspect", "mesh", "build", "render",
                                         "validate", "export",  "view", "synth", "chart"};

std::vector<std::string> lines_of(const Arguments& arguments) {
  const Outcome outcome = lumatlas_here(arguments);
  CHECK(outcome.status == 0);
  CHECK(outcome.err.empty());
  std::vector<std::string> lines;
  std::istringstream text(outcome.out);
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

// Help without its line breaks.
std::string unbroken_help(const Arguments& arguments) {
  std::istringstream words(lumatlas_here(arguments).out);
  std::string text;
  for (std::string word; words >> word;) text += (text.empty() ? "" : " ") + word;
  return text;
}

// The settings that have a line of their own, "  coverage.metric NAME", by their names.
std::vector<std::string> settings_in(const std::vector<std::string>& lines) {
  std::vector<std::string> settings;
  for (const std::string& line : lines) {
    if (!line.starts_with("  ") || line.starts_with("   ")) continue;
    const std::string name = line.substr(2, line.find(' ', 2) - 2);
    const bool is_name = name.find_first_not_of("abcdefghijklmnopqrstuvwxyz-.") == std::string::npos;
    if (is_name && name.find('.') != std::string::npos) settings.push_back(name);
  }
  return settings;
}

// Those that have a line of their own, by their long names.
std::set<std::string> options_in(const std::vector<std::string>& lines) {
  std::set<std::string> options;
  for (const std::string& line : lines) {
    const std::size_t start = line.find("--");
    if (start > 6 || !line.starts_with("  ")) continue;  // "  --name" or "  -o, --name"
    options.insert(line.substr(start, line.find(' ', start) - start));
  }
  return options;
}

TEST_CASE("the help of each command fits a screen") {
  for (const std::string& command : kCommands) {
    CAPTURE(command);
    const std::vector<std::string> lines = lines_of({command, "--help"});
    CHECK(lines.size() <= 40);
    CHECK(lines.size() >= 10);
    for (const std::string& line : lines) CHECK(line.size() <= 100);
  }
  CHECK(lines_of({"--help"}).size() <= 24);
}

TEST_CASE("help names ranges, choices and defaults in plain words") {
  for (const std::string& command : kCommands) {
    for (const std::string& line : lines_of({command, "--help-all"})) {
      CAPTURE(command, line);
      CHECK(line.size() <= 100);
      for (const char* const of_machines : {"{", "ENUM", "UINT", "FLOAT", "TEXT", "INT in", " in [", "[]"}) {
        CHECK(line.find(of_machines) == std::string::npos);
      }
    }
  }
  const std::string build = unbroken_help({"build", "--help-all"}), render = unbroken_help({"render", "--help"});
  CHECK_THAT(build, Catch::Contains("(png or jpeg; default png)"));
  CHECK_THAT(build, Catch::Contains("(1 to 65536; default 16)"));
  CHECK_THAT(build, Catch::Contains("(8 to 1024, a multiple of 8; default 64)"));
  CHECK_THAT(render, Catch::Contains("(0.01 to 1000; default 30)"));
  CHECK_THAT(render, Catch::Contains("(nearby or model; default nearby, with --paper model)"));
}

TEST_CASE("what is rarely needed is listed by --help-all alone, with all that --help lists") {
  for (const std::string& command : kCommands) {
    CAPTURE(command);
    const std::vector<std::string> few = lines_of({command, "--help"}), many = lines_of({command, "--help-all"});
    const std::set<std::string> shown = options_in(few), all = options_in(many);
    for (const std::string& option : shown) {
      CAPTURE(option);
      CHECK(all.contains(option));
    }
    for (const std::string& line : few)
      CHECK_FALSE((line.starts_with("Rarely needed: ") || line.starts_with("Experiments")));
    CHECK(settings_in(few).empty());
    CHECK(shown.contains("--quiet"));
    CHECK(shown.contains("--json"));
  }
  const std::set<std::string> shown = options_in(lines_of({"build", "--help"}));
  CHECK(shown.size() <= 22);
  for (const char* const option :
       {"--output", "--mesh", "--hold", "--block", "--max-views", "--budget", "--loss", "--refine", "--cell-size",
        "--mesh-as-given", "--image", "--paper", "--verbose", "--view", "--watch"}) {
    CAPTURE(option);
    CHECK(shown.contains(option));
  }
  const std::string help = lumatlas_here({"build", "--help"}).out;
  const std::set<std::string> all = options_in(lines_of({"build", "--help-all"}));
  for (const char* const option : {"--set", "--texture", "--idle", "--any-mesh"}) {
    CAPTURE(option);
    CHECK(all.contains(option));
    CHECK_FALSE(shown.contains(option));
  }
  CHECK(all.size() <= 36);
  for (const char* const option : {"--mesh-scale", "--mesh-axes", "--mesh-shift"}) {
    CAPTURE(option);
    CHECK_THAT(help, Catch::Contains(option));
    CHECK(all.contains(option));
  }
}

TEST_CASE("--help-all lists each setting once, with its range and its default") {
  for (const std::string command : {"inspect", "mesh", "build", "render", "validate", "export"}) {
    CAPTURE(command);
    const std::vector<std::string> settings = settings_in(lines_of({command, "--help-all"}));
    CHECK(std::set<std::string>(settings.begin(), settings.end()).size() == settings.size());
    CHECK(settings.size() >= 2);
    CHECK(options_in(lines_of({command, "--help-all"})).contains("--set"));
  }
  const std::string build = unbroken_help({"build", "--help-all"});
  CHECK_THAT(build, Catch::Contains("planner.victims N "));
  CHECK_THAT(build, Catch::Contains("coverage.direction-weight W Weight of direction against position when views are "
                                    "chosen (0 to 1; default 0.35)"));
  CHECK_THAT(build, Catch::Contains("(on or off; default on)"));
  CHECK_THAT(unbroken_help({"render", "--help-all"}),
             Catch::Contains("as a share of the shorter side; printed: 0 (0 to 0.5; default 0.005)"));
}

// Names that were options once, and others that people may expect.
TEST_CASE("an option that is a setting is told as one") {
  const auto told = [](const std::string& command, const std::string& option) {
    const Outcome outcome = lumatlas_here({command, "in", "-o", "out", option});
    CHECK(outcome.status == 2);
    return outcome.err;
  };
  for (const std::string command : {"mesh", "build", "render", "validate", "export"}) {
    for (const std::string& setting : settings_in(lines_of({command, "--help-all"}))) {
      const std::string option = "--" + setting.substr(setting.find('.') + 1);
      if (options_in(lines_of({command, "--help-all"})).contains(option)) continue;
      CAPTURE(command, setting);
      CHECK_THAT(told(command, option), Catch::Contains("There is no option " + option + "; did you mean --set ") &&
                                            Catch::Contains("." + setting.substr(setting.find('.') + 1) + "=VALUE?"));
    }
  }
  CHECK_THAT(told("build", "--coverage-direction-weight"), Catch::Contains("--set coverage.direction-weight=VALUE"));
  CHECK_THAT(told("build", "--no-demand"), Catch::Contains("--set coverage.demand=VALUE"));
  CHECK_THAT(told("build", "--keep-lenses"), Catch::Contains("--set refinement.lenses=VALUE"));
  CHECK_THAT(told("build", "--exact-surface"), Catch::Contains("--set surface.exact=VALUE"));
  CHECK_THAT(told("render", "--consistency"), Catch::Contains("--set blend.consistent=VALUE"));
  CHECK_THAT(told("build", "--max-vews"), Catch::Contains("did you mean --max-views?"));
  CHECK_THAT(lumatlas_here({"build", "in", "-o", "out", "--set", "coverage.metrik=printed"}).err,
             Catch::StartsWith("--set: there is no setting coverage.metrik; did you mean coverage.metric?"));
}

}  // namespace
}  // namespace lumatlas
