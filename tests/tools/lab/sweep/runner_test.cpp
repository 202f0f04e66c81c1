// SPDX-License-Identifier: GPL-3.0-or-later
// Sweeps by a program that stands in for lumatlas: a script that notes each call and answers at once.
#include "tools/lab/sweep/runner.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <string>
#include <vector>

#include "mesh/base/temporary_entry.h"
#include "tests/support/temporary_folder.h"
#include "tools/base/process/machine.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using Status = PointResult::Status;

// Fails as lumatlas does where it is told --max-views=13, --neighbors=13 or --seed=13; PSNR is the number of views.
constexpr const char* kStandIn = R"(#!/bin/sh
here=$(dirname "$0")
echo "$@" >>"$here/calls"
for argument; do
  case $argument in
    --output=*) output=${argument#--output=} ;;
    --max-views=13 | --neighbors=13 | --seed=13)
      echo "warning" >&2
      echo "lumatlas: thirteen: is unlucky" >&2
      exit 1 ;;
    --max-views=14) kill -KILL $$ ;;
  esac
done
[ "$1" = mesh ] || mkdir -p "$output"
case $1 in
  mesh) echo ply >"$output"; echo '{"faces": 7}' ;;
  synth) echo "{\"lumatlas\": \"\", \"options\": {}}" >"$output/lumatlas.json" ;;
  build) echo "$@" >"$output/scene.gltf"; echo '{"cells": 7}' ;;
  validate) echo '{"methods": {"store": {"raw": {"psnr": 30}}}}' ;;
esac
)";

struct Stage {
  TemporaryFolder folder;
  fs::path program = folder.with_file("lumatlas", kStandIn);
  Stage() { fs::permissions(program, fs::perms::owner_all); }

  [[nodiscard]] SweepRunOptions options() const {
    SweepRunOptions options;
    options.program = program;
    options.identity = "one";
    options.output = folder / "out";
    options.quiet = true;
    return options;
  }
  // The calls since the last time, of this command.
  [[nodiscard]] std::size_t calls(const std::string& command) const {
    std::ifstream file(folder / "calls");
    std::size_t count = 0, line_number = 0;
    for (std::string line; std::getline(file, line); ++line_number) {
      count += line_number >= seen_ && line.starts_with(command + " ") ? 1 : 0;
    }
    return count;
  }
  void forget_calls() {
    std::ifstream file(folder / "calls");
    seen_ = static_cast<std::size_t>(std::count(std::istreambuf_iterator<char>(file), {}, '\n'));
  }

 private:
  std::size_t seen_ = 0;
};

// One scene, one series, these numbers of views.
Sweep sweep_of(const std::vector<std::string>& views) {
  Sweep sweep;
  sweep.name = "views";
  sweep.scenes = {{.name = "tiny", .folder = "", .kind = "apartment", .options = {}}};
  SweepSeries series{.label = "ours", .mark = {}, .once = false, .options = {}, .values = {}};
  for (const std::string& number : views) {
    SweepValue value{.label = number, .x = {}, .options = {}};
    value.options.build["max-views"] = {true, number};
    series.values.push_back(value);
  }
  sweep.series = {series};
  return sweep;
}

std::vector<PointResult> run(const Sweep& sweep, const SweepRunOptions& options) {
  return SweepRunner(options).run(sweep);
}

std::size_t made_now(const std::vector<PointResult>& results) {
  return static_cast<std::size_t>(
      std::count_if(results.begin(), results.end(), [](const PointResult& result) { return result.made_now; }));
}

TEST_CASE("a sweep makes its scene once and each point once, and finds them the next time") {
  Stage stage;
  const std::vector<PointResult> first = run(sweep_of({"1", "2", "3"}), stage.options());
  CHECK(made_now(first) == 3);
  CHECK(stage.calls("synth") == 1);
  CHECK(stage.calls("build") == 3);
  CHECK(stage.calls("validate") == 3);
  for (const PointResult& result : first) {
    CHECK(result.status == Status::done);
    CHECK(result.build["cells"] == 7);
    CHECK(result.scores["methods"]["store"]["raw"]["psnr"] == 30);
  }
  CHECK(first[1].commands ==
        std::vector<std::string>{
            "lumatlas build SCENE --output=MODEL --texture=none --mesh-as-given --json --quiet --max-views=2",
            "lumatlas validate MODEL --views=SCENE --no-pictures --json --quiet"});
  stage.forget_calls();
  const std::vector<PointResult> again = run(sweep_of({"1", "2", "3", "4"}), stage.options());
  CHECK(made_now(again) == 1);
  CHECK(again[3].made_now);
  CHECK(stage.calls("synth") == 0);
  CHECK(stage.calls("build") == 1);
  CHECK(again[1].build == first[1].build);
  CHECK(again[1].commands == first[1].commands);
}

TEST_CASE("a point with options of mesh is built on the mesh that they make, and the mesh is not kept") {
  Stage stage;
  Sweep sweep = sweep_of({"1", "2"});
  sweep.series[0].values[1].options.mesh["from"] = {true, "photographs"};
  const std::vector<PointResult> results = run(sweep, stage.options());
  CHECK(stage.calls("mesh") == 1);
  REQUIRE(results[1].status == Status::done);
  CHECK(results[1].commands ==
        std::vector<std::string>{
            "lumatlas mesh SCENE --output=MESH --json --quiet --from=photographs",
            "lumatlas build SCENE --output=MODEL --texture=none --mesh-as-given --json --quiet --mesh=MESH "
            "--max-views=2",
            "lumatlas validate MODEL --views=SCENE --no-pictures --json --quiet"});
  for (const auto& entry : fs::recursive_directory_iterator(stage.folder / "out/points")) {
    CHECK(entry.path().filename().string().find("mesh") == std::string::npos);
  }
}

TEST_CASE("a mesh that cannot be made fails its point with the program's sentence") {
  Stage stage;
  Sweep sweep = sweep_of({"1"});
  sweep.options.mesh["neighbors"] = {true, "13"};
  const std::vector<PointResult> results = run(sweep, stage.options());
  CHECK(results[0].status == Status::failed);
  CHECK(results[0].reason == "mesh: thirteen: is unlucky");
  CHECK(stage.calls("build") == 0);
}

TEST_CASE("models are not kept, and what a killed run left behind is removed") {
  Stage stage;
  const fs::path points = stage.folder / "out/points";
  CHECK(made_now(run(sweep_of({"1"}), stage.options())) == 1);
  fs::create_directories(points / random_temporary_name() / "model");
  CHECK(made_now(run(sweep_of({"1"}), stage.options())) == 0);
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(points)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  REQUIRE(names.size() == 4);
  CHECK(std::vector(names.begin() + 1, names.end()) ==
        std::vector<std::string>{"build.json", "lumatlas.json", "scores.json"});
}

TEST_CASE("a point that is damaged or another program's is made again, unless that is wanted") {
  Stage stage;
  const Sweep sweep = sweep_of({"1", "2"});
  SweepRunOptions options = stage.options();
  CHECK(made_now(run(sweep, options)) == 2);
  options.identity = "another";
  options.keep_points = true;
  const std::vector<PointResult> kept = run(sweep, options);
  CHECK(made_now(kept) == 0);
  CHECK(kept[0].made_by == "one");
  options.keep_points = false;
  CHECK(made_now(run(sweep, options)) == 2);
  for (const auto& point : fs::directory_iterator(options.output / "points")) {
    std::ofstream(point.path() / "scores.json") << "{";
    break;
  }
  CHECK(made_now(run(sweep, options)) == 1);
  CHECK(made_now(run(sweep, options)) == 0);
}

TEST_CASE("a point that fails says the program's sentence, the rest goes on, and it is tried again") {
  for (const std::size_t jobs : {1, 3}) {
    Stage stage;
    SweepRunOptions options = stage.options();
    options.jobs = jobs;
    const std::vector<PointResult> results = run(sweep_of({"1", "13", "14", "2"}), options);
    CHECK(results[0].status == Status::done);
    CHECK(results[1].status == Status::failed);
    CHECK(results[1].reason == "build: thirteen: is unlucky");
    CHECK(results[1].commands.size() == 1);
    CHECK(results[1].build.is_null());
    CHECK(results[2].status == Status::failed);
    CHECK(results[2].reason == "build: was ended by signal 9");
    CHECK(results[3].status == Status::done);
    stage.forget_calls();
    CHECK(made_now(run(sweep_of({"1", "13", "14", "2"}), options)) == 0);
    CHECK(stage.calls("build") == 2);
  }
}

TEST_CASE("a scene that cannot be made fails its points and no others") {
  Stage stage;
  Sweep sweep = sweep_of({"1", "2"});
  sweep.series[0].values[1].options.synth["seed"] = {true, "13"};
  const std::vector<PointResult> results = run(sweep, stage.options());
  CHECK(results[0].status == Status::done);
  CHECK(results[1].status == Status::failed);
  CHECK(results[1].reason == "synth: thirteen: is unlucky");
  CHECK(stage.calls("build") == 1);
}

TEST_CASE("points that are the same are made once, whatever series they belong to") {
  Stage stage;
  Sweep sweep = sweep_of({"1", "2"});
  sweep.series.push_back(sweep.series[0]);
  sweep.series[1].label = "again";
  const std::vector<PointResult> results = run(sweep, stage.options());
  CHECK(results.size() == 4);
  CHECK(stage.calls("build") == 2);
  for (const PointResult& result : results) CHECK(result.status == Status::done);
  CHECK(results[1].point.name == "tiny/again/1");
}

TEST_CASE("points are left out by their names, and skipped with a sentence where their scene is not there") {
  Stage stage;
  SweepRunOptions options = stage.options();
  options.only = {"*/2", "nothing"};
  std::vector<PointResult> results = run(sweep_of({"1", "2"}), options);
  CHECK(results[0].status == Status::left_out);
  CHECK(results[1].status == Status::done);
  options.only.clear();
  Sweep sweep = sweep_of({"1"});
  sweep.scenes = {{.name = "fox", .folder = "fox", .kind = "", .options = {}}};
  results = run(sweep, options);
  CHECK(results[0].status == Status::skipped);
  CHECK(results[0].reason == "the scene fox needs --scenes, a folder that has it");
  options.scenes = stage.folder / "scenes";
  results = run(sweep, options);
  CHECK(results[0].reason == (options.scenes / "fox").string() + ": there is no such scene");
  fs::create_directories(options.scenes / "fox");
  results = run(sweep, options);
  CHECK(results[0].status == Status::done);
  CHECK(stage.calls("synth") == 1);  // of the first sweep
}

TEST_CASE("one runner at a time works in a folder, and none in a folder that holds other files") {
  Stage stage;
  const SweepRunner first(stage.options());
  CHECK_THROWS_WITH(SweepRunner(stage.options()), Catch::Contains("another `lumatlas chart` is at work here"));
  SweepRunOptions options = stage.options();
  options.output = stage.folder.path();
  CHECK_THROWS_WITH(SweepRunner(options), Catch::Contains("is neither empty nor an earlier output"));
}

TEST_CASE("a program is known by its commit, a changed one by its file") {
  const TemporaryFolder folder;
  const fs::path one = folder.with_file("one", "abc"), other = folder.with_file("other", "abd");
  CHECK(program_identity("0.1.0", "1a2b", one) == "0.1.0 commit 1a2b");
  CHECK(program_identity("0.1.0", "1a2b", one) == program_identity("0.1.0", "1a2b", other));
  CHECK(program_identity("0.1.0", "1a2b-dirty", one) != program_identity("0.1.0", "1a2b-dirty", other));
  CHECK(program_identity("0.1.0", "", one) != program_identity("0.1.0", "", other));
  CHECK_THAT(program_identity("0.1.0", "", one), Catch::StartsWith("0.1.0 commit unknown (program "));
  CHECK(fs::equivalent(program_file(), fs::read_symlink("/proc/self/exe")));
  CHECK_THAT(machine_description(), Catch::Contains("core") && Catch::Contains("Linux"));
}

}  // namespace
}  // namespace lumatlas
