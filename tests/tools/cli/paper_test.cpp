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
  CAPTURE(switches.back());
  CHECK(outcome.status == 2);
  const std::string name =
      switches.front() == "--set" ? "--set " + switches.back().substr(0, switches.back().find('=')) : switches.front();
  CHECK_THAT(outcome.err, Catch::StartsWith(name + ": is ") && Catch::Contains(" by --paper: leave out"));
  CHECK_FALSE(fs::exists(output));
}

TEST_CASE("build --paper records what its switches one by one do") {
  const nlohmann::json paper = built_with({"--paper"});
  CHECK(paper == built_with({"--set", "coverage.metric=printed", "--set", "masks.edges=both", "--refine", "all",
                             "--set", "refinement.lenses=off", "--mesh-as-given", "--set", "surface.far-sphere=off",
                             "--set", "surface.exact=on"}));
  CHECK(paper["refine"] == "all");
  CHECK(paper["mesh_as_given"] == true);
  const nlohmann::json& settings = paper["settings"];
  CHECK(settings["coverage.metric"] == "printed");
  CHECK(settings["departures.comparison"] == "everyone");
  for (const char* const off : {"departures.first-view", "departures.hemisphere", "departures.share",
                                "departures.references", "refinement.lenses", "surface.far-sphere"}) {
    CAPTURE(off);
    CHECK(settings[off] == false);
  }
  CHECK(settings["masks.edges"] == "both");
  CHECK(settings["surface.exact"] == true);
  CHECK(settings["coverage.references"] == 16);
  CHECK(settings["planner.min-gain"] == 0.1);
  CHECK(settings["planner.min-reference-gain"] == 0.01);
}

TEST_CASE("build --paper goes with the same values, and with what the paper leaves open") {
  const Arguments same{
      "--paper",  "--set", "coverage.metric=printed", "--set", "masks.edges=both", "--set", "planner.min-gain=0.1",
      "--refine", "none"};
  CHECK(built_with(same) ==
        built_with({"--set", "coverage.metric=printed", "--set", "masks.edges=both", "--refine", "none",
                    "--mesh-as-given", "--set", "surface.far-sphere=off", "--set", "surface.exact=on"}));
  CHECK(built_with(
            {"--paper", "--refine", "none", "--set", "coverage.references=8"})["settings"]["coverage.references"] == 8);
}

TEST_CASE("build --paper contradicts what says otherwise") {
  const Arguments build{"build", made().scene};
  check_contradiction(build, {"--set", "coverage.metric=directions"});
  check_contradiction(build, {"--set", "coverage.metric=departures"});
  check_contradiction(build, {"--set", "departures.share=on"});
  check_contradiction(build, {"--set", "surface.far-sphere=on"});
  check_contradiction(build, {"--set", "surface.exact=off"});
  check_contradiction(build, {"--set", "refinement.lenses=on"});
  check_contradiction(build, {"--set", "masks.edges=far"});
  check_contradiction(build, {"--set", "planner.min-gain=0.001"});
  check_contradiction(build, {"--set", "planner.min-reference-gain=0"});
  const Outcome automatic = lumatlas_here({"build", made().scene, "-o", "unused", "--paper", "--budget", "auto"});
  CHECK(automatic.status == 2);
  CHECK_THAT(automatic.err, Catch::Contains("--budget auto: needs coverage.metric=directions"));
}

TEST_CASE("render and validate --paper record what blend.weights=printed does") {
  const Arguments render{"render", made().model, "--views", made().scene, "--hold", "4"};
  const nlohmann::json drawn = drawn_with(render, {"--paper"});
  if (drawn.is_null()) return;
  CHECK(drawn == drawn_with(render, {"--set", "blend.weights=printed"}));
  CHECK(drawn["settings"]["blend.weights"] == "printed");
  CHECK(drawn["settings"]["blend.position"] == "printed");
  CHECK(drawn["settings"]["blend.rims"] == false);
  CHECK(drawn["settings"]["blend.sampling"] == "linear");
  CHECK(drawn["supersample"] == 1);
  CHECK(drawn == drawn_with(render, {"--paper", "--exposure", "model", "--set", "blend.sampling=linear", "--set",
                                     "blend.border-width=0", "--set", "blend.frame-fade=0"}));
  const Arguments validate{"validate",      made().model,     "--views",     made().scene,
                           "--no-pictures", "--no-alignment", "--baselines", "none"};
  CHECK(drawn_with(validate, {"--paper"}) == drawn_with(validate, {"--set", "blend.weights=printed"}));
}

TEST_CASE("render and validate --paper contradict what says otherwise") {
  for (const Arguments& command : {Arguments{"render", made().model, "--views", made().scene},
                                   Arguments{"validate", made().model, "--views", made().scene}}) {
    check_contradiction(command, {"--set", "blend.weights=ratio"});
    check_contradiction(command, {"--set", "blend.rims=on"});
    check_contradiction(command, {"--set", "blend.sampling=cubic"});
    check_contradiction(command, {"--exposure", "nearby"});
    check_contradiction(command, {"--set", "blend.soften=on"});
    check_contradiction(command, {"--set", "blend.soft-edges=on"});
    check_contradiction(command, {"--set", "blend.outlines=on"});
    check_contradiction(command, {"--set", "blend.prefilter=on"});
    check_contradiction(command, {"--set", "blend.consistent=on"});
    check_contradiction(command, {"--set", "blend.frame-fade=0.02"});
    check_contradiction(command, {"--set", "blend.border-width=0.1"});
    check_contradiction(command, {"--supersample", "2"});
  }
}

}  // namespace
}  // namespace lumatlas
