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
  const std::string build = lumatlas_here({"build", "--help-all"}).out, render = lumatlas({"render", "--help"}).out;
  CHECK_THAT(build, Catch::Contains("(png or jpeg; default png)"));
  CHECK_THAT(build, Catch::Contains("(1 to 65536; default 16)"));
  CHECK_THAT(build, Catch::Contains("(8 to 1024, a multiple of 8; default 64)"));
  CHECK_THAT(render, Catch::Contains("(0.01 to 1000; default 30)"));
  CHECK_THAT(render, Catch::Contains("(nearby or model; default nearby, printed model)"));
}

TEST_CASE("experiments are listed by --help-all alone, with all that --help lists") {
  for (const std::string& command : kCommands) {
    CAPTURE(command);
    const std::vector<std::string> few = lines_of({command, "--help"}), many = lines_of({command, "--help-all"});
    const std::set<std::string> shown = options_in(few), all = options_in(many);
    for (const std::string& option : shown) {
      CAPTURE(option);
      CHECK(all.contains(option));
    }
    for (const std::string& line : few) CHECK_FALSE(line.starts_with("Experiments: "));
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
  CHECK(all.contains("--victims"));
  for (const char* const option : {"--mesh-scale", "--mesh-axes", "--mesh-shift"}) {
    CAPTURE(option);
    CHECK_THAT(help, Catch::Contains(option));
    CHECK(all.contains(option));
  }
  CHECK_FALSE(shown.contains("--victims"));
}

}  // namespace
}  // namespace lumatlas
