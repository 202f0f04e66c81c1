// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/sweep.h"

#include <catch2/catch.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/sweep/points.h"

namespace lumatlas {
namespace {

using nlohmann::json;

// Two scenes at scale full, two series, two values.
json valid_sweep() {
  return json::parse(R"({
    "name": "cells", "title": "Cells", "expected": "More is better.", "label": "views",
    "scenes": {
      "small": [{"name": "tiny", "synth": {"kind": "apartment", "photographs": 8}}],
      "full": [{"name": "large", "synth": {"kind": "apartment", "photographs": 80}},
               {"name": "other", "synth": {"kind": "apartment", "seed": 2}, "build": {"hold": 7}}]
    },
    "build": {"hold": 4, "refine": "none"},
    "validate": {"baselines": ["vertex", "unbounded"], "no-alignment": true},
    "option": {"build": "max-views"},
    "values": {"small": [1, 2], "full": [1, 2, {"label": "most", "x": 9, "value": "=offered"}]},
    "series": [{"label": "ours", "mark": "default"},
               {"label": "printed", "mark": "printed", "build": {"coverage.metric": "printed", "refine": null}}],
    "repeats": {"small": 0, "full": 2},
    "metrics": ["psnr.fitted"],
    "plots": [{"x": "value", "y": ["psnr.fitted"], "log": "x"}],
    "breaking": {"metric": "psnr.fitted", "fall": 1}
  })");
}

bool knows(const std::string& command, const std::string& option) {
  static const std::set<std::string> options{"build hold",
                                             "build refine",
                                             "build max-views",
                                             "build coverage.metric",
                                             "build coverage.demand",
                                             "build stream.order",
                                             "build stream.seed",
                                             "validate baselines",
                                             "validate no-alignment",
                                             "synth photographs",
                                             "synth seed",
                                             "synth pose-noise",
                                             "build output",
                                             "mesh from",
                                             "mesh output"};
  return options.contains(command + " " + option);
}

Sweep read(const json& description, SweepScale scale = SweepScale::small) {
  const TemporaryFolder folder;
  std::vector<Sweep> sweeps = read_sweeps(folder.with_file("sweep.json", description.dump()), scale, knows);
  REQUIRE(sweeps.size() == 1);
  return sweeps.front();
}

std::string refusal_of_text(const std::string& text) {
  const TemporaryFolder folder;
  try {
    (void)read_sweeps(folder.with_file("sweep.json", text), SweepScale::small, knows);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string refusal_of(const std::function<void(json&)>& change) {
  json description = valid_sweep();
  change(description);
  return refusal_of_text(description.dump());
}

TEST_CASE("a sweep takes from full what it has no medium of") {
  json description = valid_sweep();
  description["values"]["medium"] = {1, 7};
  const Sweep medium = read(description, SweepScale::medium);
  CHECK(medium.scenes.size() == 2);
  CHECK(medium.repeats == 2);
  REQUIRE(medium.series[0].values.size() == 2);
  CHECK(medium.series[0].values[1].label == "7");
}

TEST_CASE("a sweep has the values of its scale, and options as the program takes them") {
  const Sweep small = read(valid_sweep()), full = read(valid_sweep(), SweepScale::full);
  CHECK(small.scenes.size() == 1);
  CHECK(full.scenes.size() == 2);
  CHECK(small.repeats == 0);
  CHECK(full.repeats == 2);
  CHECK(full.series[1].mark == SweepSeries::Mark::printed);
  CHECK(full.series[0].values[2].label == "most");
  CHECK(full.series[0].values[1].x == 2.0);
  CHECK(arguments_of(full.options.validate) ==
        std::vector<std::string>{"--baselines=vertex,unbounded", "--no-alignment"});
  CHECK(full.scenes[0].kind == "apartment");
  CHECK(arguments_of(full.scenes[0].options.synth) == std::vector<std::string>{"--photographs=80"});
}

// Two sweeps that differ in their names and in one value of the second.
json valid_file() {
  json common = valid_sweep();
  common.erase("name");
  json other = {{"name", "pixels"}, {"values", {{"small", {3}}, {"full", {3, 4}}}}};
  return {{"common", common}, {"sweeps", {{{"name", "cells"}}, other}}};
}

TEST_CASE("a file may have several sweeps, which are as if each had a file with what they have in common") {
  const TemporaryFolder folder;
  const auto file = folder.with_file("several.json", valid_file().dump());
  const std::vector<Sweep> sweeps = read_sweeps(file, SweepScale::full, knows);
  REQUIRE(sweeps.size() == 2);
  CHECK(sweeps[0].name == "cells");
  CHECK(sweeps[1].name == "pixels");
  CHECK(sweeps[1].title == "Cells");
  json alone = valid_sweep();
  const auto keys = [](const Sweep& sweep) {
    std::vector<std::string> all;
    for (const SweepPoint& point : points_of(sweep)) all.push_back(key_of(description_of(point)));
    return all;
  };
  CHECK(keys(sweeps[0]) == keys(read(alone, SweepScale::full)));
  alone["values"] = {{"small", {3}}, {"full", {3, 4}}};
  CHECK(keys(sweeps[1]) == keys(read(alone, SweepScale::full)));
  CHECK(sweep_named("pixels", sweeps, file).name == "pixels");
  CHECK_THROWS_WITH(sweep_named("cell", sweeps, file),
                    Catch::EndsWith("several.json: has no sweep called \"cell\", there are cells, pixels"));
}

TEST_CASE("whatever is wrong with a file of several sweeps is named with its place") {
  const auto refusal = [](const std::function<void(json&)>& change) {
    json file = valid_file();
    change(file);
    return refusal_of_text(file.dump());
  };
  CHECK(refusal([](json& /*unchanged*/) {}) == "accepted");
  CHECK_THAT(refusal([](json& f) { f["sweep"] = 1; }), Catch::Contains("sweep: is not known here: there are sweeps"));
  CHECK_THAT(refusal([](json& f) { f["sweeps"] = json::array(); }), Catch::Contains("sweeps: is empty"));
  CHECK_THAT(refusal([](json& f) { f["sweeps"] = 3; }), Catch::Contains("sweeps: must be an array, not number"));
  CHECK_THAT(refusal([](json& f) { f["sweeps"][1] = "pixels"; }),
             Catch::Contains("sweeps[1]: must be an object, not string"));
  CHECK_THAT(refusal([](json& f) { f["common"] = 1; }), Catch::Contains("common: must be an object, not number"));
  CHECK_THAT(refusal([](json& f) { f["sweeps"][1]["name"] = "cells"; }),
             Catch::Contains("sweeps[1]: the name \"cells\" occurs twice"));
  CHECK_THAT(refusal([](json& f) { f["sweeps"][1]["colour"] = 1; }),
             Catch::Contains("sweeps[1].colour: is not known here"));
  CHECK_THAT(refusal([](json& f) { f["common"].erase("title"); }), Catch::Contains("sweeps[0]: has no \"title\""));
}

TEST_CASE("a sweep may have comments, but nothing twice and nothing that is not JSON") {
  const std::string text = valid_sweep().dump();
  CHECK(refusal_of_text("// of cells\n" + text + " /* the end */") == "accepted");
  CHECK_THAT(refusal_of_text("{\"name\": \"a\", \"name\": \"b\"}"),
             Catch::Contains("has \"name\" twice in one object"));
  CHECK_THAT(refusal_of_text("{\"name\": "), Catch::Contains("sweep.json: is not JSON: parse error at line 1"));
  CHECK_THAT(refusal_of_text("{\"name\": 1e999}"), Catch::Contains("sweep.json: is not JSON: "));
  CHECK_THAT(refusal_of_text("[1]"), Catch::Contains("must be an object, not array"));
  CHECK_THROWS_WITH(read_sweeps("/no/sweep.json", SweepScale::small, knows), "/no/sweep.json: no such file");
}

TEST_CASE("whatever is wrong with a sweep is named with its place") {
  struct Wrong {
    std::function<void(json&)> change;
    const char* complaint;
  };
  const std::vector<Wrong> all{
      {[](json& s) { s["colour"] = 1; }, "colour: is not known here: there are name, title"},
      {[](json& s) { s.erase("title"); }, "sweep.json: has no \"title\""},
      {[](json& s) { s["title"] = 3; }, "title: must be a text, not number"},
      {[](json& s) { s["title"] = "two\nlines"; }, "title: must be a text of one line"},
      {[](json& s) { s["name"] = "../cells"; }, "name: is \"../cells\", must be of a-z, 0-9 and '-'"},
      {[](json& s) {
         s["values"] = {1, 2};
       },
       "values: must be an object, not array"},
      {[](json& s) { s["values"].erase("full"); }, "values: has no \"full\""},
      {[](json& s) { s["values"]["small"] = json::array(); }, "values: has no value at scale small"},
      {[](json& s) {
         s["values"]["small"] = {1, 1};
       },
       "values.small[1]: \"1\" occurs twice"},
      {[](json& s) { s["values"]["small"][0] = json::array({json::array({1})}); },
       "values.small[0][0]: must be a number or a text"},
      {[](json& s) {
         s["values"]["small"][0] = {{"x", 1}};
       },
       "values.small[0]: has no \"label\""},
      {[](json& s) {
         s["values"]["small"][0] = {{"label", "a"}, {"builds", 1}};
       },
       "values.small[0].builds: is not known here"},
      {[](json& s) { s.erase("option"); }, "values.small[0]: there is no \"option\" that it could be a value of"},
      {[](json& s) {
         s["option"] = {{"build", "vews"}};
       },
       "option.build: `lumatlas build` has no option --vews"},
      {[](json& s) { s["option"] = json::object(); }, "option: must name one option"},
      {[](json& s) { s["build"]["cell-sise"] = 1; }, "build.cell-sise: `lumatlas build` has no option --cell-sise"},
      {[](json& s) { s["build"]["coverage.metrik"] = 1; },
       "build.coverage.metrik: `lumatlas build` has no setting coverage.metrik"},
      {[](json& s) { s["build"]["set"] = "coverage.metric=printed"; },
       "build.set: --set is for `lumatlas chart` to give"},
      {[](json& s) { s["build"]["output"] = "x"; }, "build.output: --output is for `lumatlas chart` to give"},
      {[](json& s) { s["validate"]["views"] = "x"; }, "validate.views: --views is for `lumatlas chart` to give"},
      {[](json& s) { s["mesh"]["output"] = "x"; }, "mesh.output: --output is for `lumatlas chart` to give"},
      {[](json& s) { s["series"][0]["mesh"]["size"] = 1; }, "series[0].mesh.size: `lumatlas mesh` has no option"},
      {[](json& s) {
         s["build"]["hold"] = {{"a", 1}};
       },
       "build.hold: must be a number, a text, true, false or a list"},
      {[](json& s) { s["series"] = json::array(); }, "series: is empty"},
      {[](json& s) { s["series"][1]["label"] = "ours"; }, "series[1]: \"ours\" occurs twice"},
      {[](json& s) { s["series"][1]["mark"] = "best"; },
       "series[1].mark: is \"best\", must be one of default, printed"},
      {[](json& s) { s["series"][1]["once"] = 1; }, "series[1].once: must be true or false, not number"},
      {[](json& s) {
         s["series"][1]["synth"] = {{"fog", 1}};
       },
       "series[1].synth.fog: `lumatlas synth` has no option"},
      {[](json& s) { s["scenes"]["small"] = json::array(); }, "scenes: has none at scale small"},
      {[](json& s) { s["scenes"]["small"][0].erase("synth"); }, "scenes.small[0]: must have either \"folder\""},
      {[](json& s) { s["scenes"]["small"][0]["synth"].erase("kind"); }, "scenes.small[0].synth: has no \"kind\""},
      {[](json& s) {
         s["scenes"]["small"][0] = {{"name", "a"}, {"folder", "../a"}};
       },
       "scenes.small[0].folder: must be the name of a folder below --scenes"},
      {[](json& s) {
         s["scenes"]["small"][0] = {{"name", "a"}, {"folder", "/a"}};
       },
       "scenes.small[0].folder: must be the name of a folder below --scenes"},
      {[](json& s) {
         s["scenes"]["small"][0] = {{"name", "a"}, {"folder", "a"}};
         s["series"][0]["synth"] = {{"pose-noise", 1}};
       },
       "scenes: the scene \"a\" is a folder, but the series \"ours\" changes options of `lumatlas synth`"},
      {[](json& s) {
         s["repeats"] = {{"small", -1}, {"full", 1}};
       },
       "repeats.small: is -1, must be a whole number from 0"},
      {[](json& s) { s["repeats"] = 3; }, "repeats: must be an object, not number"},
      {[](json& s) { s["metrics"] = json::array(); }, "metrics: is empty"},
      {[](json& s) { s["metrics"][0] = "psnr"; }, "metrics[0]: is \"psnr\", must be a metric: psnr.frame.raw, "},
      {[](json& s) { s["plots"][0]["y"] = {"time"}; }, "plots[0].y[0]: is \"time\", must be a metric"},
      {[](json& s) { s["plots"][0]["x"] = "size"; }, "plots[0].x: is \"size\", must be a metric"},
      {[](json& s) { s["plots"][0]["log"] = "z"; }, "plots[0].log: is \"z\", must be one of x, y, xy"},
      {[](json& s) { s["plots"][0]["front"] = true; }, "plots[0]: a front needs metrics"},
      {[](json& s) { s["plots"][0]["x"] = "label"; }, "plots[0]: labels are evenly spaced"},
      {[](json& s) {
         s["plots"][0]["lines"] = {{{"at", "1"}, {"label", "a"}}};
       },
       "plots[0].lines[0].at: is \"1\", must be a number"},
      {[](json& s) {
         s["values"]["small"][0] = {{"label", "a"}, {"value", 3}};
       },
       "plots[0]: the value \"a\" of \"ours\" has no \"x\""},
      {[](json& s) {
         s["values"]["small"][0] = {{"label", "a"}, {"value", 3}, {"x", 0}};
       },
       "plots[0]: the value \"a\" of \"ours\" has no logarithm"},
      {[](json& s) { s["breaking"]["fall"] = 0; }, "breaking.fall: must be above 0"},
      {[](json& s) { s["breaking"]["metric"] = "views.offered"; }, "breaking: needs a metric of which more or less"},
      {[](json& s) { s["scored_on"] = "truth"; }, "scored_on: is \"truth\", must be one of same, undisturbed"},
  };
  CHECK(refusal_of([](json& /*unchanged*/) {}) == "accepted");
  for (const Wrong& wrong : all) {
    const std::string refusal = refusal_of(wrong.change);
    CHECK_THAT(refusal, Catch::Contains(wrong.complaint) && Catch::Contains("sweep.json: "));
    CHECK(refusal.find('\n') == std::string::npos);
  }
}

TEST_CASE("options of scene, series and value replace those before, and null takes them back") {
  const std::vector<SweepPoint> points = points_of(read(valid_sweep(), SweepScale::full));
  // Two scenes, three values, two series and two orders.
  REQUIRE(points.size() == 24);
  CHECK(points[0].name == "large/ours/1/1");
  CHECK(points[1].name == "large/printed/1/1");  // what is compared is made one after the other
  CHECK(points[2].name == "large/ours/2/1");
  CHECK(points[6].name == "other/ours/1/1");
  CHECK(points[12].name == "large/ours/1/2");
  CHECK(arguments_of(points[0].build) == std::vector<std::string>{"--hold=4", "--max-views=1", "--refine=none",
                                                                  "--set=stream.order=shuffled",
                                                                  "--set=stream.seed=1"});
  CHECK(arguments_of(points[7].build) == std::vector<std::string>{"--set=coverage.metric=printed", "--hold=7",
                                                                  "--max-views=1", "--set=stream.order=shuffled",
                                                                  "--set=stream.seed=1"});
}

TEST_CASE("a name with a point is that of a setting, whose true and false are on and off") {
  json description = valid_sweep();
  description["build"] = {{"coverage.demand", false}, {"coverage.metric", "printed"}};
  const SweepPoint off = points_of(read(description))[0];
  CHECK(arguments_of(off.build) ==
        std::vector<std::string>{"--set=coverage.demand=off", "--set=coverage.metric=printed", "--max-views=1"});
  description["build"]["coverage.demand"] = true;
  description["series"][0]["build"] = {{"coverage.metric", nullptr}};
  const SweepPoint on = points_of(read(description))[0];
  CHECK(arguments_of(on.build) == std::vector<std::string>{"--set=coverage.demand=on", "--max-views=1"});
}

TEST_CASE("a series that is told to be made once has one run, in the given order") {
  json description = valid_sweep();
  description["series"][1]["once"] = true;
  const std::vector<SweepPoint> points = points_of(read(description, SweepScale::full));
  CHECK(points.size() == 18);
  CHECK(points[0].name == "large/printed/1");
  CHECK_FALSE(points[0].seed);
  CHECK_FALSE(points[0].build.contains("stream.order"));
}

TEST_CASE("keys depend on every option and on nothing else, and are the same everywhere") {
  const std::vector<SweepPoint> points = points_of(read(valid_sweep(), SweepScale::full));
  std::set<std::string> keys;
  for (const SweepPoint& point : points) keys.insert(key_of(description_of(point)));
  CHECK(keys.size() == points.size());
  json renamed = valid_sweep();
  renamed["name"] = renamed["title"] = "another";
  renamed["series"][0]["label"] = "mine";
  CHECK(key_of(description_of(points_of(read(renamed, SweepScale::full))[0])) == key_of(description_of(points[0])));
  CHECK(key_of(json::array()) == "09612b07b5ecb5a5");  // FNV-1a of "[]", by another implementation
}

TEST_CASE("a series that makes a mesh has points of its own, and others keep their keys") {
  json description = valid_sweep();
  const std::string before = key_of(description_of(points_of(read(description))[0]));
  description["series"][1] = {{"label", "own mesh"}, {"mesh", {{"from", "photographs"}}}};
  const std::vector<SweepPoint> points = points_of(read(description));
  CHECK(key_of(description_of(points[0])) == before);
  CHECK(points[0].mesh.empty());
  CHECK(arguments_of(points[1].mesh) == std::vector<std::string>{"--from=photographs"});
  CHECK(points[1].build == points[0].build);
  CHECK(key_of(description_of(points[1])) != before);
}

TEST_CASE("points are scored on the photographs of the scene, disturbed or not") {
  json description = valid_sweep();
  description["option"] = {{"synth", "pose-noise"}};
  const SweepPoint same = points_of(read(description))[0];
  CHECK(same.scored_synth == same.synth);
  CHECK(same.synth.contains("pose-noise"));
  description["scored_on"] = "undisturbed";
  const SweepPoint undisturbed = points_of(read(description))[0];
  CHECK_FALSE(undisturbed.scored_synth.contains("pose-noise"));
  CHECK(undisturbed.scored_synth.contains("photographs"));
  CHECK(key_of(description_of(same)) != key_of(description_of(undisturbed)));
}

}  // namespace
}  // namespace lumatlas
