// SPDX-License-Identifier: GPL-3.0-or-later
// --paper is the printed method in one word, in every command that has a part of it.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"

namespace lumatlas {
namespace {

// The options that a build with these switches recorded.
nlohmann::json built_with(const Arguments& switches) {
  const TemporaryFolder folder;
  const std::string model = (folder / "model").string();
  Arguments arguments{"build", made().scene, kLargeCells, "-o", model, "--hold", "4", "--max-views", "5", "--quiet"};
  arguments.insert(arguments.end(), switches.begin(), switches.end());
  REQUIRE(lumatlas_here(arguments).status == 0);
  return options_beside(model);
}

// The same of a command that needs a GPU; null where there is none.
nlohmann::json drawn_with(Arguments arguments, const Arguments& switches) {
  const TemporaryFolder folder;
  const std::string output = (folder / "output").string();
  arguments.insert(arguments.end(), {"-o", output, "--quiet"});
  arguments.insert(arguments.end(), switches.begin(), switches.end());
  const Outcome outcome = lumatlas_here(arguments);
  if (outcome.err.find("no OpenGL 4.5") != std::string::npos) {
    WARN("skipped: " << outcome.err);
    return {};
  }
  REQUIRE(outcome.status == 0);
  return options_beside(output);
}

// Wrong usage that names the option and --paper, before anything is made.
void check_contradiction(Arguments arguments, const Arguments& switches) {
  const TemporaryFolder folder;
  const std::string output = (folder / "output").string();
  arguments.insert(arguments.end(), {"-o", output, "--paper"});
  arguments.insert(arguments.end(), switches.begin(), switches.end());
  const Outcome outcome = lumatlas_here(arguments);
  CAPTURE(switches.front());
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.err, Catch::StartsWith(switches.front() + ": is ") && Catch::Contains(" by --paper: leave out"));
  CHECK_FALSE(fs::exists(output));
}

TEST_CASE("build --paper records what its switches one by one do") {
  const nlohmann::json paper = built_with({"--paper"});
  CHECK(paper == built_with({"--metric", "printed", "--edges", "both", "--refine", "all", "--keep-lenses",
                             "--mesh-as-given", "--no-far-sphere", "--exact-surface"}));
  CHECK(paper["metric"] == "printed");
  CHECK(paper["depart"].empty());
  CHECK(paper["edges"] == "both");
  CHECK(paper["refine"] == "all");
  CHECK(paper["refine_lenses"] == false);
  CHECK(paper["references"] == 16);
  CHECK(paper["min_view_gain"] == 0.1);
  CHECK(paper["min_reference_gain"] == 0.01);
}

TEST_CASE("build --paper goes with the same values, and with what the paper leaves open") {
  const Arguments same{"--paper", "--metric", "printed", "--edges", "both", "--min-gain", "0.1", "--refine", "none"};
  CHECK(built_with(same) == built_with({"--metric", "printed", "--edges", "both", "--refine", "none", "--mesh-as-given",
                                        "--no-far-sphere", "--exact-surface"}));
  CHECK(built_with({"--paper", "--refine", "none", "--references", "8"})["references"] == 8);
}

TEST_CASE("build --paper contradicts what says otherwise") {
  const Arguments build{"build", made().scene};
  check_contradiction(build, {"--metric", "directions"});
  check_contradiction(build, {"--metric", "departures"});
  check_contradiction(build, {"--depart", "share"});
  check_contradiction(build, {"--edges", "far"});
  check_contradiction(build, {"--min-gain", "0.001"});
  check_contradiction(build, {"--min-reference-gain", "0"});
  const Outcome automatic = lumatlas_here({"build", made().scene, "-o", "unused", "--paper", "--budget", "auto"});
  CHECK(automatic.status == 2);
  CHECK_THAT(automatic.err, Catch::Contains("--budget auto: needs --metric directions"));
}

TEST_CASE("render and validate --paper record what --weights printed does") {
  const Arguments render{"render", made().model, "--views", made().scene, "--hold", "4"};
  const nlohmann::json drawn = drawn_with(render, {"--paper"});
  if (drawn.is_null()) return;
  CHECK(drawn == drawn_with(render, {"--weights", "printed"}));
  CHECK(drawn["weights"] == "printed");
  CHECK(drawn["blend_depart"].empty());
  CHECK(drawn["sampling"] == "linear");
  CHECK(drawn["supersample"] == 1);
  CHECK(drawn == drawn_with(render, {"--paper", "--exposure", "model", "--sampling", "linear", "--border-width", "0",
                                     "--frame-fade", "0"}));
  const Arguments validate{"validate",      made().model,     "--views",     made().scene,
                           "--no-pictures", "--no-alignment", "--baselines", "none"};
  CHECK(drawn_with(validate, {"--paper"}) == drawn_with(validate, {"--weights", "printed"}));
}

TEST_CASE("render and validate --paper contradict what says otherwise") {
  for (const Arguments& command : {Arguments{"render", made().model, "--views", made().scene},
                                   Arguments{"validate", made().model, "--views", made().scene}}) {
    check_contradiction(command, {"--weights", "ratio"});
    check_contradiction(command, {"--blend-depart", "rims"});
    check_contradiction(command, {"--sampling", "cubic"});
    check_contradiction(command, {"--exposure", "nearby"});
    check_contradiction(command, {"--soften", "on"});
    check_contradiction(command, {"--prefilter", "on"});
    check_contradiction(command, {"--consistency", "on"});
    check_contradiction(command, {"--frame-fade", "0.02"});
    check_contradiction(command, {"--border-width", "0.1"});
    check_contradiction(command, {"--supersample", "2"});
  }
}

}  // namespace
}  // namespace lumatlas
