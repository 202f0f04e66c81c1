// SPDX-License-Identifier: GPL-3.0-or-later
// What --json prints, and the page that lists its keys: tools/cli/README.md.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"

namespace lumatlas {
namespace {

using nlohmann::json;
using Keys = std::set<std::string>;

// "cells", and "views.offered" of what holds further keys, in an object or in objects of a list.
void collect_keys(const json& printed, Keys& keys) {
  for (const auto& [key, value] : printed.items()) {
    const json& inner = value.is_array() && !value.empty() ? value.front() : value;
    if (!inner.is_object()) keys.insert(key);
    if (!inner.is_object()) continue;
    for (const auto& [name, member] : inner.items()) keys.insert(key + "." + name);
  }
}

// What a command printed for --json, whose first key is the version.
json printed_by(const Outcome& outcome, Keys& keys) {
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const nlohmann::ordered_json ordered = nlohmann::ordered_json::parse(outcome.out);
  CHECK(ordered.begin().key() == "lumatlas");
  CHECK("lumatlas " + ordered["lumatlas"].get<std::string>() + "\n" == lumatlas_here({"--version"}).out);
  const json printed = json::parse(outcome.out);
  collect_keys(printed, keys);
  return printed;
}

// The keys in the first column of the table below this heading of the page.
Keys keys_on_page(const std::string& heading) {
  std::istringstream page(bytes_of(LUMATLAS_CLI_PAGE));
  Keys keys;
  bool is_here = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("#")) is_here = line == heading;
    if (!is_here || !line.starts_with("| `")) continue;
    std::istringstream cell(line.substr(1, line.find('|', 1) - 1));
    for (std::string word; cell >> word;) {
      if (!word.starts_with('`')) continue;
      keys.insert(word.substr(1, word.rfind('`') - 1));
    }
  }
  keys.insert("lumatlas");  // said once, for all commands
  return keys;
}

// A key that stands for whatever lies below it is on the page without what lies below.
void check_page(const std::string& heading, const Keys& printed) {
  const Keys page = keys_on_page(heading);
  for (const std::string& key : printed) {
    CAPTURE(heading, key);
    CHECK(page.contains(key));
  }
  for (const std::string& key : page) {
    CAPTURE(heading, key);
    CHECK(printed.contains(key));
  }
}

TEST_CASE("every key that build, mesh, inspect, export and synth print is on the page, and no other") {
  Keys build, mesh, of_model, of_scene, exported, synth;
  const TemporaryFolder folder;
  const std::string model = (folder / "model").string();
  printed_by(made().build, build);
  const Arguments more{"build", made().scene, kLargeCells, "-o", model, "--refine", "none", "--json", "--quiet"};
  for (const Arguments& of : {Arguments{"--budget", "auto"}, Arguments{"--set", "stream.choice=offline"}}) {
    Arguments arguments = more;
    arguments.insert(arguments.end(), of.begin(), of.end());
    printed_by(lumatlas_here(arguments), build);
    printed_by(lumatlas_here({"inspect", model, "--json"}), of_model);
  }
  for (const char* const empty_above : {"parsimony", "offline", "lenses", "trust"}) build.erase(empty_above);
  for (const char* const empty_above : {"parsimony", "trust"}) of_model.erase(empty_above);
  printed_by(lumatlas_here({"inspect", made().scene, "--json", "--quiet"}), of_scene);
  const std::string ply = (folder / "mesh.ply").string();
  printed_by(lumatlas_here({"mesh", made().scene, "-o", ply, "--json", "--quiet"}), mesh);
  const json scene = printed_by(made().synth, synth);
  CHECK(scene["photographs"] == 12);
  CHECK(scene["path_frames"] == 3);
  const json textured = printed_by(
      lumatlas_here({"export", made().model, "-o", (folder / "plain.glb").string(), "--json", "--quiet"}), exported);
  CHECK(textured["format"] == "glb");
  CHECK(textured["texture"]["pages"] == 1);
  const json page = printed_by(
      lumatlas_here({"export", made().model, "--to", "web", "-o", (folder / "page").string(), "--json", "--quiet"}),
      exported);
  CHECK(page["format"] == "web");
  CHECK(page["views"] == 9);
  CHECK(page["scale"] == 1);
  check_page("### export", exported);
  check_page("### build", build);
  check_page("### mesh", mesh);
  check_page("### inspect MODEL", of_model);
  check_page("### inspect SCENE", of_scene);
  check_page("### synth", synth);
}

TEST_CASE("every key that render, validate and chart print is on the page, and no other") {
  Keys render, validate, chart;
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  const Outcome drawn = lumatlas_here({"render", made().model, "--orbit", "--frames", "2", "--width", "32", "--height",
                                       "24", "-o", out, "--json", "--quiet"});
  if (drawn.err.find("no OpenGL 4.5") != std::string::npos) {
    WARN("skipped: " << drawn.err);
    return;
  }
  const json pictures = printed_by(drawn, render);
  CHECK(pictures["pictures"] == 2);
  CHECK(pictures["format"] == "png");
  const Arguments scored{"validate",
                         made().model,
                         "--views",
                         made().scene,
                         "--no-pictures",
                         "--no-alignment",
                         "--baselines",
                         "texture,texture-all,unbounded,vertex",
                         "-o",
                         out + "-report",
                         "--json",
                         "--quiet",
                         "--time-frames",
                         "1",
                         "--set",
                         "timing.width=32",
                         "--set",
                         "timing.height=24"};
  printed_by(lumatlas_here(scored), validate);
  Arguments tested = scored;
  tested.insert(tested.end(), {"--test", made().scene + "/test"});
  printed_by(lumatlas_here(tested), validate);
  const auto sweep = folder.with_file("one.json", R"({
    "name": "one", "title": "One point", "expected": "It works.", "label": "references",
    "scenes": {"small": [{"name": "room", "synth": {"kind": "apartment", "photographs": 6, "width": 40, "height": 30,
                                                    "samples": 1, "triangles": 2000}}],
               "full": [{"name": "room", "synth": {"kind": "apartment"}}]},
    "build": {"hold": 3, "refine": "none"}, "validate": {"baselines": "none", "no-alignment": true},
    "option": {"build": "coverage.references"}, "values": {"small": [4], "full": [16]}, "series": [{"label": "ours"}],
    "metrics": ["psnr.fitted"], "plots": []})");
  const json charted = printed_by(
      lumatlas({"chart", sweep.string(), "-o", out + "-chart", "--scale", "small", "--json", "--quiet"}), chart);
  CHECK(charted["points"]["done"] == 1);
  CHECK(charted["sweeps"][0]["points"] == json{"room/ours/4"});
  check_page("### render", render);
  check_page("### validate", validate);
  check_page("### chart", chart);
}

}  // namespace
}  // namespace lumatlas
