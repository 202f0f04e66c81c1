// SPDX-License-Identifier: GPL-3.0-or-later
// The program as a user starts it, on a tiny synthetic scene: exit statuses, sentences, outputs that are whole or
// absent.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "mesh/readers/mesh_file.h"
#include "tests/support/scenes/plain_model.h"
#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"

namespace lumatlas {
namespace {

// Asks the program to stop as soon as its output grows, and checks that nothing remains of it in `folder`.
void check_interrupted(const Arguments& arguments, const fs::path& folder) {
  const std::vector<std::string> before = names_in(folder);
  const Run run(arguments);
  for (int wait = 0; wait < 2000 && names_in(folder) == before; ++wait) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  run.send(SIGINT);
  const Outcome outcome = run.wait();
  INFO(outcome.err);
  CHECK(outcome.status == -SIGINT);
  CHECK(outcome.out.empty());
  CHECK(names_in(folder) == before);
}

TEST_CASE("a scene is made and built, quietly, and the summary is JSON and nothing else") {
  CHECK(made().synth.status == 0);
  CHECK(made().synth.err.empty());
  REQUIRE(made().build.status == 0);
  CHECK(made().build.err.empty());
  const nlohmann::json summary = nlohmann::json::parse(made().build.out);
  CHECK(summary["views"]["offered"] == 9);  // 12 less every fourth
  // One tile holds a picture of 64x48 pixels, with a gutter of 2 around it.
  CHECK(summary["texels"]["resident"].get<std::size_t>() == summary["views"]["kept"].get<std::size_t>() * 68 * 68);
}

// Of a folder of pictures, by name.
std::vector<std::string> picture_bytes(const fs::path& folder) {
  std::vector<std::string> names = names_in(folder), bytes;
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) {
    if (name.ends_with(".png")) bytes.push_back(bytes_of(folder / name));
  }
  return bytes;
}

TEST_CASE("a model may be one file: it renders the same pictures as the folder, and tells how it was built") {
  const TemporaryFolder folder;
  const std::string file = (folder / "model.glb").string();
  REQUIRE(lumatlas_here({"build", made().scene, kLargeCells, "-o", file, "--hold", "4", "--quiet"}).status == 0);
  CHECK(names_in(folder.path()) == std::vector<std::string>{"model.glb"});
  const std::string from_folder = (folder / "a").string(), from_file = (folder / "b").string();
  REQUIRE(lumatlas_here({"render", made().model, "--views", made().scene, "-o", from_folder, "--quiet"}).status == 0);
  REQUIRE(lumatlas_here({"render", file, "--views", made().scene, "-o", from_file, "--quiet"}).status == 0);
  CHECK(picture_bytes(from_folder).size() == 12);
  CHECK((picture_bytes(from_folder) == picture_bytes(from_file)));
  const Outcome scored = lumatlas_here({"validate", file, "--views", made().scene, "--no-alignment", "--no-pictures",
                                        "--baselines", "none", "--json", "--quiet"});
  REQUIRE(scored.status == 0);
  CHECK(nlohmann::json::parse(scored.out)["protocol"]["hold"] == 4);  // from the file
  CHECK(fs::exists(folder / "model-report/index.html"));
}

TEST_CASE("inspect tells a model from a scene") {
  const TemporaryFolder folder;
  const std::string unbounded = (folder / "unbounded.glb").string(), file = (folder / "model.glb").string();
  const Outcome built = lumatlas_here({"build", made().scene, "-o", unbounded, "--hold", "4", "--json", "--quiet"});
  const nlohmann::json summary = nlohmann::json::parse(built.out);
  const nlohmann::json whole = nlohmann::json::parse(lumatlas_here({"inspect", unbounded, "--json"}).out);
  CHECK(whole["views"]["count"] == summary["views"]["stored"]);
  CHECK(whole["references"]["per_cell"] == summary["references_per_cell"]);
  CHECK(whole["texels"]["resident"] == summary["texels"]["resident"]);
  CHECK(whole["bytes"]["resident"] == summary["bytes"]["resident"]);
  CHECK(whole["bytes"]["budget"].is_null());
  const std::size_t budget = whole["gpu"]["sum"].get<std::size_t>() - whole["gpu"]["colors"].get<std::size_t>() / 2;
  REQUIRE(lumatlas_here({"build", made().scene, "-o", file, "--hold", "4", "--budget", std::to_string(budget),
                         "--image", "jpeg", "--quality", "80", "--quiet"})
              .status == 0);
  const nlohmann::json model = nlohmann::json::parse(lumatlas_here({"inspect", file, "--json"}).out);
  CHECK(model["bytes"]["budget"] == budget);
  CHECK(model["gpu"]["sum"].get<std::size_t>() <= budget);
  CHECK(whole["gpu"] == summary["gpu"]);
  CHECK(whole["file"]["sum"] == summary["file"]["sum"]);
  CHECK(model["tiles"]["resident"].get<std::size_t>() <= model["tiles"]["of"].get<std::size_t>());
  CHECK(model["tiles"]["of"].get<std::size_t>() < whole["tiles"]["of"].get<std::size_t>());
  CHECK(model["file"]["sum"].get<std::size_t>() <= fs::file_size(file));
  CHECK(model["file"]["sum"].get<std::size_t>() > fs::file_size(file) * 99 / 100);
  CHECK_THAT(lumatlas_here({"inspect", file}).out, Catch::Contains("; budget "));
}

TEST_CASE("a model that is as small as a bound on the loss allows says what it gave up, and how much that may cost") {
  const TemporaryFolder folder;
  const std::string model = (folder / "model").string();
  const Outcome built = lumatlas_here({"build", made().scene, kLargeCells, "-o", model, "--budget", "auto", "--loss",
                                       "1.5", "--refine", "none", "--json", "--quiet"});
  REQUIRE(built.status == 0);
  const nlohmann::json parsimony = nlohmann::json::parse(built.out)["parsimony"];
  CHECK(parsimony["bound_db"] == 1.5);
  CHECK(parsimony["predicted_loss_db"] <= 1.5);
  CHECK(parsimony["views"]["unbounded"] == 12);
  CHECK(parsimony["views"]["stored"] < 12);
  CHECK(parsimony["references"]["stored"] < parsimony["references"]["unbounded"]);
  CHECK(parsimony["gpu_bytes"]["stored"] < parsimony["gpu_bytes"]["before"]);
  CHECK(options_beside(model)["faces_pixels"] == 0.5);  // a small model has no faces that no picture shows
  CHECK(options_beside(made().model)["faces_pixels"] == 0);
  const auto faces_pixels = [&](const Arguments& budget) {
    Arguments arguments{"build",    made().scene, kLargeCells, "-o", (folder / "bounded").string(),
                        "--refine", "none",       "--quiet"};
    arguments.insert(arguments.end(), budget.begin(), budget.end());
    REQUIRE(lumatlas_here(arguments).status == 0);
    return options_beside(folder / "bounded")["faces_pixels"];
  };
  CHECK(faces_pixels({"--budget", "50MB"}) == 0.5);
  CHECK(faces_pixels({"--budget", "50MB", "--faces", "keep"}) == 0);
  CHECK(faces_pixels({"--budget", "5Mtexels"}) == 0);  // which do not bound the mesh
  CHECK(faces_pixels({"--budget", "50MB", "--set", "tiles.layout=layers"}) == 0);
  for (const Arguments& all_faces : {Arguments{"--faces", "keep"}, Arguments{"--loss", "0"}}) {
    Arguments arguments{"build",    made().scene, kLargeCells, "-o",   (folder / "other").string(),
                        "--budget", "auto",       "--refine",  "none", "--quiet"};
    arguments.insert(arguments.end(), all_faces.begin(), all_faces.end());
    REQUIRE(lumatlas_here(arguments).status == 0);
    CHECK(options_beside(folder / "other")["faces_pixels"] == 0);
  }
  CHECK(nlohmann::json::parse(lumatlas_here({"inspect", model, "--json"}).out)["parsimony"] == parsimony);
  CHECK_THAT(lumatlas_here({"inspect", model}).out, Catch::Contains(" of at most 1.5 against all views"));
  CHECK(nlohmann::json::parse(lumatlas_here({"inspect", made().model, "--json"}).out)["parsimony"].is_null());
}

TEST_CASE("inspect speaks JSON and finds nothing wrong with a synthetic scene") {
  const Outcome outcome = lumatlas_here({"inspect", made().scene, "--json", "--quiet"});
  REQUIRE(outcome.status == 0);
  CHECK(outcome.err.empty());
  const nlohmann::json scene = nlohmann::json::parse(outcome.out);
  CHECK(scene["views"]["count"] == 12);
  CHECK(scene["views"]["blind"].empty());
}

TEST_CASE("export writes one file or a folder, and replaces nothing but an earlier export") {
  const TemporaryFolder folder;
  const std::string file = (folder / "plain.glb").string();
  REQUIRE(lumatlas_here({"export", made().model, "-o", file, "--quiet"}).status == 0);
  const std::string first = bytes_of(file);
  CHECK(first.starts_with("glTF"));
  const Outcome again = lumatlas_here({"export", made().model, "-o", file, "--quiet"});
  CHECK(again.status == 0);
  CHECK(again.err.empty());
  CHECK_THAT(again.out, Catch::Contains("1 page of") && Catch::Contains("1.00 texels for each pixel"));
  CHECK(bytes_of(file) == first);
  // It is no model, and a model is no export.
  check_failure(lumatlas_here({"inspect", file}), "plain.glb");
  const std::string model = (folder / "model.glb").string();
  REQUIRE(lumatlas_here({"build", made().scene, kLargeCells, "-o", model, "--refine", "none", "--quiet"}).status == 0);
  const std::string kept = bytes_of(model);
  check_failure(lumatlas_here({"export", made().model, "-o", model, "--quiet"}),
                "nothing that `lumatlas export` wrote");
  CHECK(bytes_of(model) == kept);
  check_failure(lumatlas_here({"build", made().scene, "-o", file, "--refine", "none", "--quiet"}),
                "no model that `lumatlas build` wrote");
  CHECK(bytes_of(file) == first);
  check_failure(lumatlas_here({"export", made().model, "--to", "obj", "-o", made().model, "--quiet"}), "model");

  for (const char* const format : {"gltf", "obj"}) {
    const fs::path out = folder / format;
    const Arguments arguments{"export", made().model, "--to", format,    "-o", out.string(), "--image",
                              "jpeg",   "--texture",  "256",  "--pages", "9",  "--quiet"};
    const Outcome written = lumatlas_here(arguments);
    INFO(written.err);
    REQUIRE(written.status == 0);
    CHECK(fs::exists(out / (std::string("scene.") + format)));
    CHECK(fs::exists(out / "texture-0.jpg"));
    CHECK(options_beside(out)["texture"] == 256);
    REQUIRE(lumatlas_here(arguments).status == 0);
    std::ofstream(out / "mine.txt") << "of a person";
    check_failure(lumatlas_here(arguments), "mine.txt");
  }
}

TEST_CASE("export --from reads what the model did not keep, and nothing that was held out") {
  const TemporaryFolder folder;
  const fs::path scene = folder / "scene";
  fs::copy(made().scene, scene, fs::copy_options::recursive);
  const std::string model = (folder / "model").string(), out = (folder / "plain.glb").string();
  REQUIRE(
      lumatlas_here({"build", scene.string(), kLargeCells, "-o", model, "--hold", "4", "--max-views", "3", "--quiet"})
          .status == 0);
  std::vector<std::string> names = names_in(scene / "images");
  std::sort(names.begin(), names.end());
  REQUIRE(names.size() == 12);
  const auto damage = [&](const std::string& name) {
    const fs::path image = scene / "images" / name;
    fs::resize_file(image, fs::file_size(image) / 2);
  };
  for (const std::size_t held : {0u, 4u, 8u}) damage(names[held]);
  const Arguments arguments{"export", model, "--from", scene.string(), "-o", out, "--json", "--quiet"};
  const Outcome written = lumatlas_here(arguments);
  INFO(written.err);
  REQUIRE(written.status == 0);
  CHECK(written.err.empty());
  const nlohmann::json photographs = nlohmann::json::parse(written.out)["photographs"];
  CHECK(photographs["used"].get<int>() + photographs["outliers"].get<int>() == 9);
  CHECK(photographs["used"] > 3);
  const std::string kept = bytes_of(out);
  for (const std::string& name : names) damage(name);
  check_failure(lumatlas_here(arguments), scene.string());
  CHECK(bytes_of(out) == kept);
  check_failure(lumatlas_here({"export", model, "--from", (folder / "nowhere").string(), "-o", out}), "nowhere");
}

TEST_CASE("a page for browsers is a folder or one file, and replaces nothing but an earlier one") {
  const TemporaryFolder folder;
  const fs::path site = folder / "site";
  const Arguments to_folder{"export", made().model, "--to", "web", "-o", site.string(), "--quiet"};
  const Outcome written = lumatlas_here(to_folder);
  INFO(written.err);
  REQUIRE(written.status == 0);
  CHECK_THAT(written.out, Catch::Contains("9 photographs"));
  const nlohmann::json tileset = nlohmann::json::parse(bytes_of(site / "tileset.json"));
  std::vector<std::string> names{"index.html", "viewer.js", "shaders.json", tileset["root"]["content"]["uri"]};
  for (const auto& image : tileset["extensions"]["LUMATLAS_lumigraph"]["images"]) names.push_back(image["uri"]);
  CHECK(names.size() > 3 * 9);
  for (const std::string& name : names) {
    INFO(name);
    CHECK(fs::exists(site / name));
  }
  CHECK(options_beside(site)["quality"] == 90);
  REQUIRE(lumatlas_here(to_folder).status == 0);

  const fs::path file = folder / "page.html";
  const Arguments to_file{"export", made().model, "--to", "web", "-o", file.string(), "--quiet", "--image", "png"};
  REQUIRE(lumatlas_here(to_file).status == 0);
  CHECK(bytes_of(file).starts_with("<!doctype html>"));
  REQUIRE(lumatlas_here(to_file).status == 0);
  std::ofstream(file) << "<!doctype html> of a person";
  check_failure(lumatlas_here(to_file), "no page that `lumatlas export` wrote");
  CHECK(bytes_of(file) == "<!doctype html> of a person");
}

TEST_CASE("view prints an address of this machine alone, and ends by Ctrl-C") {
  const Run run({"view", made().model, "--no-browser"});
  std::string out;
  for (int i = 0; i < 600 && !out.ends_with('\n'); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    out = run.out();
  }
  CHECK(out.starts_with("http://127.0.0.1:"));
  run.send(SIGINT);
  const Outcome ended = run.wait();
  CHECK(ended.status == -SIGINT);
  CHECK(ended.out == out);
}

TEST_CASE("a model under the name of what export makes of one is refused before anything is built") {
  const TemporaryFolder folder;
  for (const auto& [name, form] : {std::pair{"x.obj", "obj"}, {"x.GLTF", "gltf"}, {"x.html", "web"}}) {
    const std::string out = (folder / name).string();
    for (const std::string command : {"build", "capture"}) {
      const Outcome outcome = lumatlas_here({command, made().scene, "-o", out});
      INFO(outcome.err);
      CHECK(outcome.status == 2);
      CHECK(outcome.err.find(out) != std::string::npos);
      CHECK(outcome.err.find(std::string("export MODEL --to ") + form) != std::string::npos);
      CHECK_FALSE(std::filesystem::exists(out));
    }
  }
}

TEST_CASE("export refuses what is no model, and pages that are too few") {
  const TemporaryFolder folder;
  const std::string out = (folder / "plain.glb").string();
  check_failure(lumatlas_here({"export", (folder / "nothing").string(), "-o", out}), "nothing");
  check_failure(lumatlas_here({"export", made().scene, "-o", out}), "scene");
  const std::string cut_off = folder.with_file("cut.glb", "glTF").string();
  check_failure(lumatlas_here({"export", cut_off, "-o", out}), "cut.glb");
  check_failure(lumatlas_here({"export", made().model, "-o", out, "--texture", "64", "--quiet"}), "--texture");
  CHECK(names_in(folder.path()) == std::vector<std::string>{"cut.glb"});
}

TEST_CASE("wrong usage ends with 2, before any output is made") {
  const std::string out = (made().folder / "unused").string();
  const std::vector<Arguments> wrong{
      {},
      {"paint"},
      {"build", made().scene},
      {"build", made().scene, "-o", out, "--unknown"},
      {"build", made().scene, "-o", out, "--max-views", "0"},
      {"build", made().scene, "-o", out, "--image", "gif"},
      {"build", made().scene, "-o", out, "--quality", "90"},
      {"build", made().scene, "-o", out, "--image", "jpeg", "--quality", "0"},
      {"build", made().scene, "-o", out, "--image", "jpeg", "--quality", "101"},
      {"inspect", made().model, "--mesh", "mesh.ply"},
      {"inspect", made().model, "--cell-size", "1"},
      {"inspect", made().model, "--set", "cells.partition=grid"},
      {"mesh", made().scene, "-o", out + ".ply", "--voxel", "0.1"},
      {"mesh", made().scene, "-o", out + ".ply", "--most-faces", "500"},
      {"mesh", made().scene, "-o", out + ".ply", "--depth-unit", "0.001"},
      {"build", made().scene, "-o", out, "--set", "tiles.layout=layers", "--set", "tiles.gutter=2"},
      {"build", made().scene, "-o", out, "--set", "tiles.layout=layers", "--set", "tiles.texels=bc7"},
      {"build", made().scene, "-o", out, "--refine", "none", "--set", "alignment.white-balance=on"},
      {"build", made().scene, "-o", out, "--refine", "exposure", "--set", "alignment.prior=1"},
      {"build", made().scene, "-o", out, "--refine", "none", "--set", "alignment.max-move=0.1"},
      {"render", made().model, "-o", out, "--orbit", "--no-color-bar"},
      {"build", made().scene, "-o", out, "--max-views", "-3"},
      {"build", made().scene, "-o", out, "--max-views", "99999999999999999999"},
      {"build", made().scene, "-o", out, "--block", "2"},
      {"build", made().scene, "-o", out, "--watch", "--hold", "4"},
      {"build", made().scene, "-o", out, "--watch", "--set", "stream.choice=offline"},
      {"build", made().scene, "-o", out, "--watch", "--set", "stream.order=reversed"},
      {"build", made().scene, "-o", out, "--watch", "--budget", "auto"},
      {"build", made().scene, "-o", out, "--idle", "5"},
      {"build", made().scene, "-o", out, "--view", "--no-browser", "--quiet", "--json"},
      {"build", made().scene, "-o", out, "--refine", "pose", "--set", "refinement.lenses=off"},
      {"build", made().scene, "-o", out, "--set", "coverage.ideal-distance=nan"},
      {"build", made().scene, "-o", out, "--set", "coverage.ideal-distance=2"},
      {"build", made().scene, "-o", out, "--set", "coverage.demand-prior=-1"},
      {"build", made().scene, "-o", out, "--set", "coverage.demand-prior=inf"},
      {"build", made().scene, "-o", out, "--set", "coverage.direction-weight=nan"},
      {"build", made().scene, "-o", out, "--cell-size", "inf"},
      {"build", made().scene, "-o", out, "--set", "planner.min-gain=-1"},
      {"build", made().scene, "-o", out, "--set", "planner.min-exchange-gain=inf"},
      {"build", made().scene, "-o", out, "--set", "planner.min-reference-gain=nan"},
      {"build", made().scene, "-o", out, "--set", "planner.victims=-1"},
      {"build", made().scene, "-o", out, "--set", "coverage.directions=0"},
      {"build", made().scene, "-o", out, "--set", "coverage.direction-width=0"},
      {"build", made().scene, "-o", out, "--set", "coverage.direction-width=181"},
      {"build", made().scene, "-o", out, "--set", "coverage.views-per-direction=9"},
      {"build", made().scene, "-o", out, "--set", "coverage.metric=paper"},
      {"build", made().scene, "-o", out, "--set", "departures.share=on"},
      {"build", made().scene, "-o", out, "--set", "planner.victims"},
      {"build", made().scene, "-o", out, "--set", "planner.victims=1", "--set", "planner.victims=2"},
      {"build", made().scene, "-o", out, "--min-gain", "0"},
      {"build", made().scene, "-o", out, "--set", "coverage.metric=printed", "--set", "departures.sideways=on"},
      {"build", made().scene, "-o", out, "--set", "coverage.metric=printed", "--set", "departures.comparison=both"},
      {"build", made().scene, "-o", out, "--set", "stream.order=backwards"},
      {"build", made().scene, "-o", out, "--set", "stream.choice=best"},
      {"build", made().scene, "-o", out, "--set", "stream.seed=1"},
      {"build", made().scene, "-o", out, "--set", "stream.order=shuffled", "--set", "stream.seed=-1"},
      {"build", made().scene, "-o", out, "--set", "stream.order=shuffled", "--set", "stream.seed=18446744073709551616"},
      {"build", made().scene, "-o", out, "--set", "stream.order=1"},
      {"build", made().scene, "-o", ""},
      {"build", "", "-o", out},
      {"build", made().scene, "-o", out, "--budget", "0"},
      {"build", made().scene, "-o", out, "--budget", "-5"},
      {"build", made().scene, "-o", out, "--budget", "MB"},
      {"build", made().scene, "-o", out, "--budget", "1.5GiB"},
      {"build", made().scene, "-o", out, "--budget", "12 parsecs"},
      {"build", made().scene, "-o", out, "--budget", "99999999999TiB"},
      {"build", made().scene, "-o", out, "--budget", "0texels"},
      {"build", made().scene, "-o", out, "--budget", "3texts"},
      {"build", made().scene, "-o", out, "--budget", "automatic"},
      {"build", made().scene, "-o", out, "--loss", "0.1"},
      {"build", made().scene, "-o", out, "--budget", "1MiB", "--loss", "0.1"},
      {"build", made().scene, "-o", out, "--budget", "auto", "--loss", "-0.1"},
      {"build", made().scene, "-o", out, "--budget", "auto", "--loss", "nan"},
      {"build", made().scene, "-o", out, "--budget", "auto", "--loss", "inf"},
      {"build", made().scene, "-o", out, "--budget", "auto", "--set", "stream.choice=offline"},
      {"build", made().scene, "-o", out, "--budget", "auto", "--set", "coverage.metric=printed"},
      {"build", made().scene, "-o", out, "--set", "tiles.tile=12"},
      {"build", made().scene, "-o", out, "--set", "tiles.gutter=3"},
      {"build", made().scene, "-o", out, "--set", "tiles.texels=bc7", "--set", "tiles.gutter=1"},
      {"build", made().scene, "-o", out, "--set", "tiles.texels=bc7", "--set", "tiles.gutter=8", "--set",
       "tiles.tile=24"},
      {"build", made().scene, "-o", out, "--set", "tiles.layout=quilt"},
      {"build", made().scene, "-o", out, "--set", "tiles.layout=layers", "--set", "tiles.tile=64"},
      {"build", made().scene, "-o", out, "--set", "tiles.layout=layers", "--photograph-bytes", "1MiB"},
      {"build", made().scene, "-o", out, "--budget", "100"},
      {"build", made().scene, "-o", out, "--set", "budget.least-scale=0.5"},
      {"build", made().scene, "-o", out, "--budget", "1Mtexels", "--set", "budget.least-scale=0.5"},
      {"build", made().scene, "-o", out, "--budget", "1MiB", "--set", "budget.least-scale=1.5"},
      {"build", made().scene, "-o", out, "--budget", "auto", "--set", "tiles.layout=layers", "--set",
       "budget.least-scale=0.5"},
      {"build", made().scene, "-o", out, "--set", "tiles.texels=bc1"},
      {"build", made().scene, "-o", out, "--visibility-by", "sonar"},
      {"render", made().model, "--views", made().scene, "-o", out, "--set", "blend.direction-weight=nan"},
      {"render", made().model, "--views", made().scene, "-o", out, "--supersample", "0"},
      {"render", made().model, "--views", made().scene, "-o", out, "--supersample", "5"},
      {"render", made().model, "--views", made().scene, "-o", out, "--set", "blend.antialias=edges"},
      {"render", made().model, "--views", made().scene, "-o", out, "--exposure", "mine"},
      {"render", made().model, "-o", out},
      {"render", made().model, "-o", out, "--orbit", "--walk"},
      {"render", made().model, "-o", out, "--path", ""},
      {"render", made().model, "-o", out, "--views", ""},
      {"render", "", "-o", out, "--orbit"},
      {"render", made().model, "-o", out, "--views", made().scene, "--hilbert"},
      {"render", made().model, "-o", out, "--views", made().scene, "--frames", "3"},
      {"render", made().model, "-o", out, "--views", made().scene, "--width", "30"},
      {"render", made().model, "-o", out, "--orbit", "--hold", "8"},
      {"render", made().model, "-o", out, "--orbit", "--set", "path.hilbert-order=2"},
      {"render", made().model, "-o", out, "--hilbert", "--set", "path.hilbert-order=9"},
      {"render", made().model, "-o", out, "--orbit", "--frames", "0"},
      {"render", made().model, "-o", out, "--orbit", "--width", "65537"},
      {"render", made().model, "-o", out, "--orbit", "--height", "0"},
      {"render", made().model, "-o", out, "--orbit", "--width", "65536", "--height", "65536"},
      {"render", made().model, "-o", out, "--orbit", "--fov", "nan"},
      {"render", made().model, "-o", out, "--orbit", "--fov", "171"},
      {"render", made().model, "-o", out, "--orbit", "--mode", "xray"},
      {"render", made().model, "-o", out, "--orbit", "--mode", "error"},
      {"render", made().model, "-o", out, "--orbit", "--mode", "cells", "--range", "0", "1"},
      {"render", made().model, "-o", out, "--orbit", "--mode", "depth", "--range", "1"},
      {"render", made().model, "-o", out, "--orbit", "--mode", "depth", "--range", "2", "1"},
      {"render", made().model, "-o", out, "--orbit", "--mode", "depth", "--range", "0", "inf"},
      {"render", made().model, "-o", out, "--orbit", "--format", "gif"},
      {"render", made().model, "-o", out, "--orbit", "--fps", "24"},
      {"render", made().model, "-o", out, "--orbit", "--format", "mp4", "--fps", "0"},
      {"export", made().model},
      {"export", made().model, "-o", out},
      {"export", made().model, "-o", out, "--to", "fbx"},
      {"export", made().model, "-o", out, "--to", "obj", "--quality", "90"},
      {"export", made().model, "-o", out, "--to", "obj", "--texture", "63"},
      {"export", made().model, "-o", out, "--to", "obj", "--texture", "16385"},
      {"export", made().model, "-o", out, "--to", "obj", "--pages", "0"},
      {"export", made().model, "-o", out, "--to", "obj", "--density", "nan"},
      {"export", made().model, "-o", out, "--to", "obj", "--set", "color.tolerance=0"},
      {"export", made().model, "-o", out, "--to", "web", "--density", "1"},
      {"export", made().model, "-o", out, "--to", "web", "--as-scene"},
      {"export", made().model, "-o", out, "--to", "web", "--from", made().scene},
      {"export", made().model, "-o", out, "--to", "web", "--image", "webp"},
      {"export", made().model, "-o", out, "--to", "obj", "--image", "webp"},
      {"export", made().model, "-o", out + ".glb", "--image", "webp", "--texture", "16384"},
      {"export", made().model, "-o", out + ".glb", "--masks", made().scene},
      {"export", made().model, "-o", out, "--to", "web", "--image", "png", "--quality", "80"},
      {"view"},
      {"view", made().model, "--port", "70000"},
      {"synth", "apartment", "-o", out, "--fov", "nan"},
      {"synth", "apartment", "-o", out, "--photographs", "0"},
      {"synth", "apartment", "-o", out, "--passers-by", "1.5"},
      {"synth", "apartment", "-o", out, "--pose-noise", "-1"},
      {"synth", "apartment", "-o", out, "--noise", "-1"},
      {"synth", "lab", "-o", out, "--blur", "nan"},
      {"synth", "lab", "-o", out, "--mesh-noise", "2"},
      {"synth", "lab", "-o", out, "--holes", "0.96"},
      {"synth", "lab", "-o", out, "--decimate", "0"},
      {"synth", "castle", "-o", out},
      {"synth", "lab", "-o", out, "--seed", "-1"},
      {"synth", "lab", "-o", out, "--photographs", "-1"},
      {"synth", "lab", "-o", out, "--views", "4"},
      {"validate", made().model, "--views", made().scene, "-o", out, "--test", ""},
      {"validate", made().model, "--views", made().scene, "-o", out, "--path", made().scene + "/path"},
      {"validate", made().model, "--views", made().scene, "-o", out, "--time-frames", "0"},
  };
  for (const Arguments& arguments : wrong) {
    const Outcome outcome = lumatlas_here(arguments);
    INFO(outcome.err);
    CHECK(outcome.status == 2);
    CHECK(outcome.out.empty());
    CHECK_FALSE(outcome.err.empty());
    if (arguments.size() < 3) {
      const Outcome of_process = lumatlas_here(arguments);
      CHECK(of_process.status == 2);
      CHECK(of_process.out.empty());
      CHECK(of_process.err == outcome.err);
    }
    CHECK_FALSE(fs::exists(out));
  }
}

TEST_CASE("an option that is refused is told in one sentence of plain words") {
  const std::string out = (made().folder / "unused").string();
  const auto complaint = [&](const Arguments& arguments) {
    const Outcome outcome = lumatlas_here(arguments);
    CHECK(outcome.status == 2);
    CHECK(outcome.out.empty());
    return outcome.err.substr(0, outcome.err.find('\n'));
  };
  const std::string seed = ": -1 is not a whole number from 0 to 18446744073709551615";
  CHECK(complaint({"build", made().scene, "-o", out, "--set", "stream.order=shuffled", "--set", "stream.seed=-1"}) ==
        "--set stream.seed" + seed);
  CHECK(complaint({"synth", "lab", "-o", out, "--seed", "-1"}) == "--seed" + seed);
  CHECK(complaint({"build", made().scene, "-o", out, "--set", "stream.order=back"}) ==
        "--set stream.order: back is not given, reversed or shuffled");
  CHECK(complaint({"build", made().scene, "-o", out, "--set", "coverage.direction-weight=nan"}) ==
        "--set coverage.direction-weight: nan is not a number from 0 to 1");
  CHECK(complaint({"build", made().scene, "-o", out, "--set", "coverage.ideal-distance=-1e-9"}) ==
        "--set coverage.ideal-distance: -1e-9 is not a finite number of 0 or more");
  CHECK(complaint({"build", made().scene, "-o", out, "--set", "tiles.texels=bc1"}) ==
        "--set tiles.texels: bc1 is not auto, rgb8 or bc7");
  CHECK(complaint({"build", made().scene, "-o", out, "--set", "tiles.tile=12"}) ==
        "--set tiles.tile: 12 is not a multiple of 8");
  CHECK(complaint({"mesh", made().scene, "-o", out + ".ply", "--spacing", "2000"}) ==
        "--spacing: 2000, must be in [0, 1000]");
  CHECK(complaint({"mesh", made().scene, "-o", out + ".ply", "--set", "cut.sure-views=-1"}) ==
        "--set cut.sure-views: -1 is not a number from 0.1 to 1000");
  CHECK(complaint({"mesh", made().scene, "-o", out + ".ply", "--voxel", "1"}) ==
        "--voxel: is for depth images, and this mesh is made of photographs");
  CHECK(complaint({"mesh", made().scene, "-o", out + ".ply", "--from", "points", "--match-size", "128"}) ==
        "--match-size: is for photographs, and this mesh is made of points");
  CHECK(complaint({"synth", "lab", "-o", out, "--fov", "500"}) == "--fov: 500, must be in (0, 170]");
  CHECK(complaint({"synth", "lab", "-o", out, "--holes", "2"}) == "--holes: 2, must be in [0, 0.95]");
  CHECK(complaint({"render", made().model, "-o", out, "--path", ""}) == "--path: is empty, must be a name");
  CHECK(complaint({"render", made().model, "-o", out}) ==
        "--views, --path, --orbit, --walk or --hilbert: must be given once, to say from where");
}

TEST_CASE("visibility on the GPU gives the model that rays give, except for a few pixels") {
  const TemporaryFolder folder;
  const auto build = [&](const std::string& way) {
    return lumatlas_here({"build", made().scene, "-o", (folder / way).string(), "--refine", "none", "--visibility-by",
                          way, "--json", "--quiet"});
  };
  const Outcome gl = build("gl");
  if (gl.err.find("no OpenGL 4.5") != std::string::npos) return skip("no GL: " + gl.err);
  REQUIRE(gl.status == 0);
  CHECK(options_beside(folder / "gl")["visibility_by"] == "gl");
  const auto by_gl = nlohmann::json::parse(gl.out);
  const auto by_rays = nlohmann::json::parse(build("rays").out);
  CHECK(options_beside(folder / "rays")["visibility_by"] == "rays");
  CHECK(by_gl["views"]["offered"] == by_rays["views"]["offered"]);
  for (const char* key : {"cells_seen", "references", "summed_coverage"}) {
    CAPTURE(key);
    CHECK(by_gl[key].get<double>() == Approx(by_rays[key].get<double>()).epsilon(0.02));
  }
}

TEST_CASE("input that does not do ends with 1 and one sentence that says what to do") {
  const std::string out = (made().folder / "unused").string();
  check_failure(lumatlas_here({"build", "/nowhere", "-o", out}), "/nowhere: no such folder");
  check_failure(lumatlas_here({"build", made().scene, "--mesh", "/no.ply", "-o", out}), "/no.ply: no such file");
  check_failure(lumatlas_here({"validate", "/nowhere", "--views", made().scene}),
                "/nowhere: no such file: give a folder");
  check_failure(lumatlas_here({"validate", made().scene, "--views", made().scene}),
                "give a folder or a .glb that `lumatlas build`");
  check_failure(lumatlas_here({"render", made().scene, "--views", made().scene, "-o", out}), made().scene);
  check_failure(lumatlas_here({"validate", made().model, "--views", made().scene, "--hold", "3"}),
                "build it with the same");
  check_failure(lumatlas_here({"validate", made().model, "--views", made().scene, "--flicker", "/nowhere"}),
                "/nowhere");
  check_failure(
      lumatlas_here({"render", made().model, "--views", made().scene, "-o", out, "--hold", "2", "--block", "99"}),
      "--hold and --block");
  check_failure(lumatlas_here({"render", made().model, "--path", "/no.json", "-o", out}), "/no.json");
  check_failure(lumatlas_here({"render", made().model, "--path", made().scene + "/mesh.ply", "-o", out}),
                "is not JSON");
  check_failure(lumatlas_here({"build", made().scene, "-o", out, "--cell-size", "1e-30"}), "give a larger --cell-size");
  check_failure(lumatlas_here({"build", made().scene, "-o", out, "--set", "tiles.layout=layers", "--budget", "20KiB"}),
                "takes 30720 bytes in the store, more than the budget of 20480");
  check_failure(lumatlas_here({"build", made().scene, "-o", out, "--budget", "40KiB"}),
                "more than the budget of 40960: give at least that as --budget");
  CHECK_FALSE(fs::exists(out));
  CHECK_FALSE(fs::exists(fs::path(made().model) / "report"));
}

TEST_CASE("a budget bounds the store in bytes, whatever its unit, and is told beside the model") {
  const TemporaryFolder folder;
  const std::string model = (folder / "model").string();
  const std::uint64_t per_view = 64 * 48 * 10;
  for (const auto& [size, bytes] : {std::pair<std::string, std::uint64_t>{"100000", 100000},
                                    {"100kB", 100000},
                                    {"97KiB", 97 * 1024},
                                    {"1mb", 1000000}}) {
    CAPTURE(size);
    const Outcome outcome =
        lumatlas_here({"build", made().scene, kLargeCells, "-o", model, "--set", "tiles.layout=layers", "--budget",
                       size, "--set", "planner.min-gain=0", "--refine", "none", "--json", "--quiet"});
    REQUIRE(outcome.status == 0);
    const nlohmann::json summary = nlohmann::json::parse(outcome.out);
    CHECK(summary["bytes"]["resident"] == std::min<std::uint64_t>(bytes / per_view, 12) * per_view);
    CHECK(options_beside(model)["budget"] == bytes);
    CHECK(options_beside(model)["max_views"].is_null());
  }
  const Outcome both =
      lumatlas_here({"build", made().scene, kLargeCells, "-o", model, "--set", "tiles.layout=layers", "--budget",
                     "1MiB", "--max-views", "2", "--set", "planner.min-gain=0", "--refine", "none", "--quiet"});
  REQUIRE(both.status == 0);
  CHECK_THAT(both.out,
             Catch::StartsWith(model + ": 2 of 12 views stored (") && Catch::Contains("; photographs 0.1 MB of 0.1\n"));
}

TEST_CASE("tiles are bounded in bytes or texels, and what is shown with all of them is what layers show") {
  const TemporaryFolder folder;
  const auto build = [&](const std::string& name, const Arguments& more) {
    Arguments arguments{"build",    made().scene,
                        "-o",       (folder / name).string(),
                        "--set",    "planner.min-gain=0",
                        "--refine", "none",
                        "--hold",   "3",
                        "--json",   "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = lumatlas_here(arguments);
    REQUIRE(outcome.status == 0);
    return nlohmann::json::parse(outcome.out);
  };
  const nlohmann::json all = build("tiles", {"--set", "tiles.tile=16", "--set", "tiles.gutter=2"});
  const std::uint64_t place_texels = 20 * 20, slot_size = (20 * 20 + 10 * 10) * 4 + 2 * 2 * 16;
  CHECK(all["texels"]["resident"].get<std::uint64_t>() / place_texels * slot_size == all["bytes"]["resident"]);
  const nlohmann::json some =
      build("some", {"--set", "tiles.tile=16", "--set", "tiles.gutter=2", "--budget", "20ktexels"});
  CHECK(some["texels"]["budget"] <= 20'000);
  CHECK(some["texels"]["resident"] <= some["texels"]["budget"]);
  CHECK(some["texels"]["resident"] > 10'000);
  CHECK(options_beside(folder / "some")["budget"] == 20'000 / place_texels * slot_size);
  CHECK(options_beside(folder / "some")["photograph_bytes"] == 4 * (20'000 / place_texels * slot_size));
  CHECK(options_beside(folder / "some")["settings"]["tiles.layout"] == "tiles");
  const std::uint64_t less = all["gpu"]["sum"].get<std::uint64_t>() - all["gpu"]["colors"].get<std::uint64_t>() / 2;
  CHECK(build("bytes", {"--set", "tiles.tile=16", "--set", "tiles.gutter=2", "--budget",
                        std::to_string(less)})["gpu"]["sum"] <= less);
  build("layers", {"--set", "tiles.layout=layers"});
  const auto score = [&](const std::string& name) {
    const Outcome outcome = lumatlas_here({"validate", (folder / name).string(), "--views", made().scene, "--hold", "3",
                                           "--baselines", "none", "--no-alignment", "--json", "--quiet"});
    return outcome.status == 0 ? nlohmann::json::parse(outcome.out)["methods"]["store"]["raw"]["psnr"].get<double>()
                               : 0;
  };
  CHECK(score("tiles") == Approx(score("layers")).margin(0.01));
}

TEST_CASE(
    "views may be offered in another order, chosen otherwise, and by another measure, which is told beside them") {
  const TemporaryFolder folder;
  const std::string model = (folder / "model").string();
  const Arguments base{"build", made().scene, kLargeCells, "-o",     model,    "--max-views",
                       "3",     "--refine",   "none",      "--json", "--quiet"};
  const auto with = [&](const Arguments& more) {
    Arguments arguments = base;
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = lumatlas_here(arguments);
    REQUIRE(outcome.status == 0);
    return options_beside(model);
  };
  const auto set_by = [&](const Arguments& more, const char* name) { return with(more)["settings"][name]; };
  CHECK(set_by({}, "coverage.metric") == "directions");
  CHECK(set_by({}, "stream.order") == "given");
  CHECK(set_by({"--set", "stream.order=shuffled", "--set", "stream.seed=7"}, "stream.seed") == 7);
  for (const char* const choice : {"offline", "uniform", "random"}) {
    CHECK(set_by({"--set", std::string("stream.choice=") + choice}, "stream.choice") == choice);
    CHECK(nlohmann::json::parse(bytes_of(fs::path(model) / "plan.json"))["summary"]["views"]["stored"] == 3);
  }
  CHECK(set_by({}, "coverage.demand") == true);
  CHECK(set_by({"--set", "coverage.demand=off"}, "coverage.demand") == false);
  CHECK(set_by({"--set", "coverage.demand=off", "--set", "coverage.ideal-distance=2"}, "coverage.ideal-distance") == 2);
  CHECK(set_by({"--set", "coverage.demand-prior=3"}, "coverage.demand-prior") == 3);
  CHECK(set_by({"--set", "coverage.metric=printed", "--set", "coverage.ideal-distance=2"}, "coverage.ideal-distance") ==
        2);
  CHECK(set_by({"--set", "coverage.metric=printed"}, "departures.hemisphere") == false);
  CHECK(set_by({"--set", "coverage.metric=departures"}, "departures.hemisphere") == true);
  // Whatever the order in which they are given, the metric does not undo the departures.
  const nlohmann::json two = with({"--set", "departures.comparison=others", "--set", "departures.first-view=on",
                                   "--set", "coverage.metric=printed"})["settings"];
  CHECK(two["coverage.metric"] == "departures");
  CHECK(two["departures.comparison"] == "others");
  CHECK(two["departures.first-view"] == true);
  CHECK(two["departures.hemisphere"] == false);
  CHECK(two["planner.min-gain"] == 0.1);
}

TEST_CASE("a folder that is not an earlier output is refused and left as it is") {
  const TemporaryFolder foreign;
  (void)foreign.with_file("letter.txt", "dear");
  const std::string out = foreign.path().string();
  check_failure(lumatlas_here({"synth", "apartment", "-o", out}), "will not be replaced");
  check_failure(lumatlas_here({"build", made().scene, "-o", out}), "will not be replaced");
  check_failure(lumatlas_here({"render", made().model, "--views", made().scene, "-o", out}), "will not be replaced");
  check_failure(lumatlas_here({"validate", made().model, "--views", made().scene, "-o", out}), "will not be replaced");
  CHECK(names_in(foreign.path()) == std::vector<std::string>{"letter.txt"});
}

TEST_CASE("an output that would take the place of its own input is refused, and the input left as it is") {
  const TemporaryFolder folder;
  fs::create_directory(folder / "outer");
  const std::string scene = (folder / "outer/scene").string(), model = (folder / "outer/model").string();
  fs::copy(made().scene, scene, fs::copy_options::recursive);
  fs::copy(made().model, model, fs::copy_options::recursive);
  fs::copy(fs::path(model) / "lumatlas.json", folder / "outer/lumatlas.json");  // an earlier output, by the look of it
  fs::create_directory_symlink(scene, folder / "link");
  const std::string outer = (folder / "outer").string(), link = (folder / "link").string();
  const std::vector<std::string> before = names_in(scene), model_before = names_in(model);
  const std::string part = "would be replaced, with the input ";
  for (const std::string& out : {scene, scene + "/", link, outer}) {
    CAPTURE(out);
    check_failure(lumatlas_here({"build", scene, "-o", out, "--quiet"}), part + scene);
    check_failure(lumatlas_here({"render", made().model, "--views", scene, "-o", out, "--quiet"}), part + scene);
    check_failure(lumatlas_here({"validate", made().model, "--views", scene, "-o", out, "--quiet"}), part + scene);
  }
  check_failure(lumatlas_here({"build", link, "-o", scene, "--quiet"}), part + link);
  check_failure(lumatlas_here({"build", made().scene, "--mesh", scene + "/mesh.ply", "-o", outer}), part + scene);
  check_failure(lumatlas_here({"render", model, "--orbit", "-o", model, "--quiet"}), part + model);
  check_failure(lumatlas_here({"validate", model, "--views", scene, "-o", outer, "--quiet"}), part + model);
  CHECK(names_in(scene) == before);
  CHECK(names_in(model) == model_before);
}

TEST_CASE("spaces, other scripts and line breaks in names are names") {
  const TemporaryFolder folder;
  const std::string scene = (folder / "my scene \xc3\xbc \xe2\x98\x83").string();
  const std::string model = (folder / "ein modell \xc3\xbc").string();
  fs::copy(made().scene, scene, fs::copy_options::recursive);
  const Outcome build =
      lumatlas_here({"build", scene, kLargeCells, "-o", model, "--hold", "4", "--refine", "none", "--quiet"});
  REQUIRE(build.status == 0);
  CHECK_THAT(build.out, Catch::StartsWith(model + ": "));
  const nlohmann::json inspected = nlohmann::json::parse(lumatlas_here({"inspect", scene, "--json", "--quiet"}).out);
  CHECK(inspected["views"]["count"] == 12);
  check_failure(lumatlas_here({"build", "no\nscene", "-o", model, "--quiet"}), "no scene: no such folder");
}

TEST_CASE("a photograph whose name is not UTF-8 is refused by build, which could not keep the name in a model") {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene").string(), model = (folder / "model").string();
  fs::copy(made().scene, scene, fs::copy_options::recursive);
  const std::string name = "0003.png", latin =
                                           "00\xfc"
                                           "3.png";
  fs::rename(fs::path(scene) / "images" / name, fs::path(scene) / "images" / latin);
  const fs::path list = fs::path(scene) / "sparse/images.bin";
  std::string bytes = bytes_of(list);
  bytes.replace(bytes.find(name), name.size(), latin);
  std::ofstream(list, std::ios::binary) << bytes;
  check_failure(lumatlas_here({"build", scene, "-o", model, "--quiet"}), latin + ": its name is not UTF-8");
  CHECK_FALSE(fs::exists(model));
}

TEST_CASE("build ends with the lines to type next, unless it is to be quiet") {
  const TemporaryFolder folder;
  const std::string model = (folder / "my model.glb").string();
  const Outcome built =
      lumatlas_here({"build", made().scene, kLargeCells, "-o", model, "--hold", "4", "--refine", "none"});
  REQUIRE(built.status == 0);
  CHECK_THAT(built.err, Catch::Contains("look at it: lumatlas view '" + model + "'\n"));
  CHECK_THAT(built.err,
             Catch::EndsWith("score it:   lumatlas validate '" + model + "' --views " + made().scene + "\n"));
}

TEST_CASE("damaged photographs are named in one line by every command that reads them") {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  const std::string header = bytes_of(fs::path(made().scene) / "images/0001.png").substr(0, 33);
  std::string other_size = bytes_of(fs::path(made().scene) / "images/0001.png");
  other_size[19] = 1;  // and so another checksum than its own
  for (const std::string& bytes : {std::string(), header.substr(0, 20), header, std::string("hello"), other_size}) {
    CAPTURE(bytes.size());
    const TemporaryFolder copy;
    const std::string scene = (copy / "scene").string(), model = (copy / "model").string();
    fs::copy(made().scene, scene, fs::copy_options::recursive);
    fs::copy(made().model, model, fs::copy_options::recursive);
    const fs::path photograph = fs::path(scene) / "images/0001.png";
    std::ofstream(photograph, std::ios::binary) << bytes;
    check_failure(lumatlas_here({"build", scene, "-o", out, "--quiet"}), photograph.string() + ": ");
    check_failure(lumatlas_here({"inspect", scene, "--quiet"}), photograph.string() + ": ");
    const fs::path stored = file_of_model(model, "images/00001.png");
    std::ofstream(stored, std::ios::binary) << bytes;
    check_failure(lumatlas_here({"render", model, "--orbit", "--mode", "depth", "-o", out, "--quiet"}),
                  stored.string());
  }
  CHECK_FALSE(fs::exists(out));
}

TEST_CASE("a model that was built from every view is not validated, but built anew with advice") {
  const TemporaryFolder folder;
  const std::string model = (folder / "model").string();
  REQUIRE(lumatlas_here({"build", made().scene, kLargeCells, "-o", model, "--quiet"}).status == 0);
  check_failure(lumatlas_here({"validate", model, "--views", made().scene, "--quiet"}), "build it with --hold 8");
}

TEST_CASE("a mesh that no camera sees is named") {
  const TemporaryFolder folder;
  const fs::path mesh = folder / "far.ply";
  write_ply(mesh, {{{1e6f, 0, 0}, {1e6f, 1, 0}, {1e6f, 0, 1}}, {}, {{0, 1, 2}}});
  check_failure(
      lumatlas_here({"build", made().scene, "--mesh", mesh.string(), "-o", (folder / "model").string(), "--quiet"}),
      mesh.string() + ": 12 of 12 views that were looked through see next to nothing of it");
  CHECK(names_in(folder.path()) == std::vector<std::string>{"far.ply"});
}

// Four points on one tiny scene.
constexpr const char* kTinySweep = R"({
  "name": "tiny", "title": "Tiny", "expected": "It works.", "label": "references",
  "scenes": {"small": [{"name": "room", "synth": {"kind": "apartment", "photographs": 8,
                                                 "width": 60, "height": 45, "samples": 1,
                                                  "triangles": 2000}}],
             "full": [{"name": "room", "synth": {"kind": "apartment"}}]},
  "build": {"hold": 4, "refine": "none", "cell-size": "=diameter/20"},
  "validate": {"baselines": "none", "no-alignment": true, "time-frames": 2, "timing.width": 32, "timing.height": 24},
  "option": {"build": "coverage.references"}, "values": {"small": [1, 4], "full": [16]},
  "series": [{"label": "ours", "mark": "default"},
             {"label": "printed", "mark": "printed", "build": {"coverage.metric": "printed"}}],
  "metrics": ["psnr.fitted", "frame.cpu"],
  "plots": [{"x": "value", "y": ["psnr.fitted", "frame.wall"], "log": "x"}]
})";

std::size_t points_in(const fs::path& out) {
  if (!fs::exists(out / "points")) return 0;
  std::size_t count = 0;
  for (const std::string& name : names_in(out / "points")) count += name.starts_with('.') ? 0 : 1;
  return count;
}

TEST_CASE("charts: a run that is killed goes on where it was, and ends with a page, CSV and JSON") {
  const TemporaryFolder folder;
  const std::string sweep = folder.with_file("tiny.json", kTinySweep).string(), out = (folder / "out").string();
  const Arguments chart{"chart", sweep, "-o", out, "--scale", "small", "--quiet"};
  const Run killed(chart);
  for (int wait = 0; wait < 20000 && points_in(out) < 1; ++wait) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  killed.send(SIGINT);
  const Outcome stopped = killed.wait();
  INFO(stopped.err);
  const std::size_t before = points_in(out);
  REQUIRE(before >= 1);
  const Outcome ended = lumatlas(chart);
  INFO(ended.err);
  if (ended.err.find("no OpenGL 4.5") != std::string::npos) return skip("no GL: " + ended.err);
  REQUIRE(ended.status == 0);
  if (stopped.status == -SIGINT) {
    CHECK_THAT(ended.out, Catch::Contains("4 of 4 points, made now " + std::to_string(4 - before)));
  }
  CHECK_THAT(lumatlas(chart).out, Catch::Contains("4 of 4 points, made now 0"));
  const nlohmann::json results = nlohmann::json::parse(bytes_of(fs::path(out) / "tiny.json"));
  CHECK(results["points"].size() == 4);
  for (const nlohmann::json& point : results["points"]) {
    CHECK(point["figures"]["psnr.fitted"].get<double>() > 5);
    CHECK(point["figures"]["frame.wall"].get<double>() > 0);
    CHECK(point["figures"]["load.read"].get<double>() > 0);
  }
  CHECK_THAT(bytes_of(fs::path(out) / "index.html"), Catch::Contains("Tiny") && Catch::Contains("ours"));
  CHECK(fs::exists(fs::path(out) / "tiny.csv"));
}

TEST_CASE("charts: a point that fails is told, with exit status 1, and the page has the others") {
  const TemporaryFolder folder;
  nlohmann::json description = nlohmann::json::parse(kTinySweep);
  description["series"][1] = {{"label", "fails"}, {"build", {{"tiles.layout", "layers"}, {"budget", 10}}}};
  description["values"]["small"] = {2};
  const std::string sweep = folder.with_file("tiny.json", description.dump()).string();
  const fs::path out = folder / "out";
  const Outcome outcome = lumatlas({"chart", sweep, "-o", out.string(), "--scale", "small", "--quiet"});
  CHECK(outcome.status == 1);
  CHECK(outcome.out.empty());
  CHECK_THAT(outcome.err, Catch::Contains("lumatlas: 1 of 2 points failed"));
  CHECK_THAT(bytes_of(out / "index.html"), Catch::Contains("<b>failed</b>: build: "));
}

TEST_CASE("charts: options that the program refuses are refused before anything is made") {
  const TemporaryFolder folder;
  const auto chart = [&](const std::string& from, const std::string& to) {
    std::string text = kTinySweep;
    text.replace(text.find(from), from.size(), to);
    return lumatlas({"chart", folder.with_file("tiny.json", text).string(), "-o", (folder / "out").string()});
  };
  check_failure(chart("\"refine\"", "\"refne\""), "tiny.json: build.refne: `lumatlas build` has no option --refne");
  check_failure(chart("\"none\", \"cell", "\"some\", \"cell"), "tiny.json: room/ours/16: build: --refine");
  check_failure(chart("[16]", "[70000]"), "tiny.json: room/ours/70000: build: --set coverage.references");
  check_failure(chart("=diameter/20", "=diameter/0"), "room/ours/16: --cell-size is \"=diameter/0\", must be");
  check_failure(chart("\"baselines\": \"none\"", "\"baselines\": \"nothing\""), "validate: --baselines");
  check_failure(chart("{\"kind\": \"apartment\"}", "{\"kind\": \"castle\"}"), "room/ours/16: synth: ");
  check_failure(lumatlas({"chart", folder.with_file("tiny.json", kTinySweep).string(), "-o", folder.path().string()}),
                "tiny.json: would be replaced, with the input");
  CHECK(names_in(folder.path()) == std::vector<std::string>{"tiny.json"});
}

TEST_CASE("charts: one sweep of a file that has several is named behind its file") {
  const std::string file = LUMATLAS_DATA "/sweeps/stability.json";
  const Outcome all = lumatlas({"chart", "--list", "--scale", "small", "--json", file});
  REQUIRE(all.status == 0);
  CHECK(nlohmann::json::parse(all.out)["sweeps"].size() == 13);
  const Outcome one = lumatlas({"chart", "--list", "--scale", "small", "--json", file + "#stability-noise"});
  REQUIRE(one.status == 0);
  const nlohmann::json sweeps = nlohmann::json::parse(one.out)["sweeps"];
  REQUIRE(sweeps.size() == 1);
  CHECK(sweeps[0]["name"] == "stability-noise");
  check_failure(lumatlas({"chart", "--list", file + "#noise"}), "stability.json: has no sweep called \"noise\"");
  check_failure(lumatlas({"chart", "--list", file, file + "#stability-noise"}), "is that of another");
}

TEST_CASE("charts: every sweep in data/sweeps is one that the program accepts, at every scale") {
  Arguments chart{"chart", "--list"};
  for (const auto& entry : fs::directory_iterator(fs::path(LUMATLAS_DATA) / "sweeps")) chart.push_back(entry.path());
  CHECK(chart.size() > 12);
  for (const char* const scale : {"small", "medium", "full"}) {
    Arguments at_scale = chart;
    at_scale.push_back(std::string("--scale=") + scale);
    const Outcome outcome = lumatlas_here(at_scale);
    INFO(outcome.err);
    CHECK(outcome.status == 0);
    CHECK_THAT(outcome.out, Catch::Contains("cell-size: apartment/clusters/1/60"));
  }
}

// For the programs that are started as long as it lives.
class Environment {
 public:
  Environment(const char* name, const char* value) : name_(name) { setenv(name, value, 1); }
  ~Environment() { unsetenv(name_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
};

TEST_CASE("a driver without OpenGL 4.5, or without an extension that is part of it, is named with what it has") {
  const TemporaryFolder folder;
  const std::string pictures = (folder / "pictures").string();
  const Arguments render{"render", made().model, "--orbit", "--frames", "1",      "--width",
                         "16",     "--height",   "12",      "-o",       pictures, "--quiet"};
  // Both are Mesa's; another driver draws the picture.
  const auto check_too_old = [&](const char* variable, const char* value) {
    const Environment old(variable, value);
    const Outcome outcome = lumatlas(render);
    if (outcome.status == 0) return skip(std::string(variable) + " does nothing here");
    check_failure(outcome, "no OpenGL 4.5 through EGL (");
    CHECK_THAT(outcome.err, Catch::Contains(": only OpenGL 3.3") || Catch::Contains(": only OpenGL 4."));
    CHECK_THAT(outcome.err, Catch::Contains("install a newer driver"));
    CHECK_FALSE(fs::exists(pictures));
  };
  check_too_old("MESA_GL_VERSION_OVERRIDE", "3.3");
  check_too_old("MESA_EXTENSION_OVERRIDE", "-GL_ARB_clip_control");
}

TEST_CASE("a model is rendered from another scene's cameras, and its scores are JSON and nothing else") {
  const TemporaryFolder folder;
  const std::string other = (folder / "other").string();
  const std::string pictures = (folder / "pictures").string();
  const std::string report = (folder / "report").string();
  REQUIRE(lumatlas_here({"synth", "apartment", "-o", other, "--photographs", "5", "--width", "40", "--height", "30",
                         "--samples", "1", "--triangles", "2000", "--quiet"})
              .status == 0);
  const Outcome render = lumatlas_here({"render", made().model, "--views", other, "-o", pictures, "--quiet"});
  if (render.err.find("no OpenGL 4.5 through EGL") != std::string::npos) return skip("no GL: " + render.err);
  REQUIRE(render.status == 0);
  CHECK(render.err.empty());
  for (const char* const name : {"0000.png", "0004.png"}) CHECK(fs::file_size(fs::path(pictures) / name) > 100);
  CHECK(options_beside(pictures)["exposure"] == "nearby");
  const std::string printed = (folder / "printed").string();
  REQUIRE(lumatlas_here(
              {"render", made().model, "--views", other, "-o", printed, "--set", "blend.weights=printed", "--quiet"})
              .status == 0);
  CHECK(options_beside(printed)["exposure"] == "model");
  const Outcome validate =
      lumatlas_here({"validate", made().model, "--views", made().scene + "/", "-o", report, "--exposure", "model",
                     "--flicker", made().scene + "/path", "--json", "--quiet"});
  REQUIRE(validate.status == 0);
  CHECK(validate.err.empty());
  const nlohmann::json scores = nlohmann::json::parse(validate.out);
  CHECK(scores == nlohmann::json::parse(bytes_of(fs::path(report) / "scores.json")));
  CHECK(scores["protocol"]["hold"] == 4);  // as the model was built
  CHECK(scores["held"] == 3);
  CHECK(scores["methods"]["store"]["seams"].is_number());
  CHECK(scores["methods"]["vertex"]["flicker"]["followed"] > 1000);
  CHECK(options_beside(report)["flicker"] == made().scene + "/path");
  CHECK_THAT(bytes_of(fs::path(report) / "index.html"), Catch::Contains("Validation of scene"));
  CHECK(options_beside(report)["exposure"] == "model");
  CHECK(names_in(folder.path()).size() == 4);
  const Outcome tested =
      lumatlas_here({"validate", made().model, "--views", made().scene, "--test", made().scene + "/test", "-o",
                     (folder / "tested").string(), "--no-pictures", "--json", "--quiet"});
  REQUIRE(tested.status == 0);
  const nlohmann::json test_scores = nlohmann::json::parse(tested.out);
  CHECK(test_scores["protocol"]["test"] == made().scene + "/test");
  CHECK(test_scores["held"] == 2);
  CHECK(test_scores["methods"]["store"]["raw"]["psnr"] > 10);  // as the random views of an apartment are to be known
  check_failure(lumatlas_here({"validate", made().model, "--views", made().scene, "--test", made().scene + "/.", "-o",
                               (folder / "same").string(), "--quiet"}),
                "name other views as a test");
  check_interrupted({"validate", made().model, "--views", made().scene, "-o", (folder / "cut").string()},
                    folder.path());
}

// Width and height in the header of a PNG file.
std::pair<std::uint32_t, std::uint32_t> png_size(const fs::path& path) {
  const std::string bytes = bytes_of(path);
  REQUIRE(bytes.substr(1, 3) == "PNG");
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
  };
  return {number(16), number(20)};
}

bool has_opengl() {
  const TemporaryFolder folder;
  const Outcome outcome = lumatlas_here({"render", made().model, "--orbit", "--frames", "1", "--width", "8", "--height",
                                         "8", "-o", (folder / "out").string(), "--quiet"});
  if (outcome.status == 0) return true;
  skip("no GL: " + outcome.err);
  return false;
}

TEST_CASE("every mode is shown with its colour bar or without, from the cameras of a scene") {
  const bool opengl = has_opengl();
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  for (const std::string mode :
       {"coverage", "references", "cells", "depth", "valid-views", "winner", "weights", "error"}) {
    if (!opengl && mode == "valid-views") break;
    CAPTURE(mode);
    const Arguments arguments{"render", made().model, "--views", made().scene, "--hold", "4",
                              "--mode", mode,         "-o",      out,          "--quiet"};
    const Outcome barred = lumatlas_here(arguments);
    REQUIRE(barred.status == 0);
    CHECK(barred.err.empty());
    CHECK(barred.out == out + ": 3 pictures\n");
    CHECK(png_size(fs::path(out) / "0004.png").second > 48 + 20);
    CHECK(options_beside(out)["mode"] == mode);
    Arguments bare = arguments;
    bare.emplace_back("--no-color-bar");
    REQUIRE(lumatlas_here(bare).status == 0);
    CHECK(png_size(fs::path(out) / "0004.png") == std::pair{64u, 48u});
    Arguments numbers = arguments;
    numbers.insert(numbers.end(), {"--format", "exr"});
    REQUIRE(lumatlas_here(numbers).status == 0);
    CHECK(bytes_of(fs::path(out) / "0004.exr").starts_with("\x76\x2f\x31\x01"));
  }
}

TEST_CASE("trust is shown by no model whose surface counts as exact") {
  const TemporaryFolder folder;
  const std::string model = (folder / "model").string(), out = (folder / "out").string();
  REQUIRE(lumatlas_here({"build", made().scene, kLargeCells, "-o", model, "--refine", "none", "--set",
                         "surface.exact=on", "--quiet"})
              .status == 0);
  check_failure(lumatlas_here({"render", model, "--views", made().scene, "--mode", "trust", "-o", out, "--quiet"}),
                "the model does not say how far its surface is off: it was built with surface.exact=on, or");
  CHECK_FALSE(fs::exists(out));
}

TEST_CASE("every kind of path gives the frames that were asked for, at their size") {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  // The last key frame looks where nothing is.
  const fs::path keys = folder.with_file("path.json", R"({"keys": [{"position": [2, 2, 1.5], "look_at": [3, 2, 1]},
    {"position": [2, 3, 1.5], "look_at": [900, 3, 1], "fov": 30},
    {"position": [700, 3, 1.5], "look_at": [900, 3, 1]}]})");
  for (const Arguments& path : std::vector<Arguments>{{"--orbit"},
                                                      {"--walk"},
                                                      {"--hilbert"},
                                                      {"--hilbert", "--set", "path.hilbert-order=1"},
                                                      {"--path", keys.string()}}) {
    CAPTURE(path.back());
    Arguments arguments{"render",   made().model, "--frames", "5",       "--width",       "40",
                        "--height", "30",         "--mode",   "depth",   "--range",       "0",
                        "8",        "-o",         out,        "--quiet", "--no-color-bar"};
    arguments.insert(arguments.end(), path.begin(), path.end());
    const Outcome outcome = lumatlas_here(arguments);
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    CHECK(outcome.out == out + ": 5 pictures\n");
    CHECK(names_in(out).size() == 6);
    CHECK(png_size(fs::path(out) / "00004.png") == std::pair{40u, 30u});
    CHECK("--" + options_beside(out)["cameras"].get<std::string>() == path.front());
    CHECK(bytes_of(fs::path(out) / "00000.png") != bytes_of(fs::path(out) / "00004.png"));
  }
}

TEST_CASE("a video is written by the ffmpeg on PATH, and refused with a sentence where there is none") {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  const Arguments arguments{"render", made().model, "--orbit",       "--frames", "4",   "--width", "30", "--height",
                            "20",     "--mode",     "depth",         "--format", "mp4", "--fps",   "12", "-o",
                            out,      "--quiet",    "--no-color-bar"};
  const std::string path = std::getenv("PATH");
  const TemporaryFolder bin;
  setenv("PATH", bin.path().c_str(), 1);
  const Outcome without = lumatlas_here(arguments);
  const fs::path fake = bin.with_file("ffmpeg", "#!/bin/sh\nfor last; do :; done\n" + std::string("PATH='") + path +
                                                    "'\nexec cat > \"${last#file:}\"\n");
  fs::permissions(fake, fs::perms::owner_all);
  const Outcome with = lumatlas_here(arguments);
  (void)bin.with_file("ffmpeg", "#!/bin/sh\necho 'no such encoder' >&2\nexit 1\n");
  const Outcome broken = lumatlas_here(arguments);
  setenv("PATH", path.c_str(), 1);
  check_failure(without, "ffmpeg: PATH has no such program");
  REQUIRE(with.status == 0);
  CHECK(with.out == out + ": 4 pictures in one video\n");
  CHECK(fs::file_size(fs::path(out) / "video.mp4") == 4 * 3 * 30 * 20);
  CHECK(options_beside(out)["fps"] == 12);
  check_failure(broken, "no such encoder");
  CHECK(fs::exists(fs::path(out) / "video.mp4"));  // the earlier one
}

TEST_CASE("Ctrl-C leaves no half output and no temporary folder") {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  check_interrupted({"synth", "apartment", "-o", out, "--photographs", "5000"}, folder.path());
  check_interrupted({"build", made().scene, "-o", out}, folder.path());
  check_interrupted({"render", made().model, "--walk", "--mode", "depth", "--frames", "100000", "-o", out},
                    folder.path());
}

TEST_CASE("build --watch waits for photographs, and Ctrl-C saves the model of those that came") {
  const TemporaryFolder folder;
  const fs::path scene = folder / "scene", out = folder / "out";
  fs::copy(made().scene, scene, fs::copy_options::recursive);
  fs::remove_all(scene / "images");
  const auto has_said = [](const Run& run, const char* words) { return run.err().find(words) != std::string::npos; };
  const Run run({"build", scene.string(), kLargeCells, "-o", out.string(), "--watch", "--json"});
  Run::wait_until([&] { return has_said(run, "waiting for photographs"); });
  fs::copy(fs::path(made().scene) / "images", scene / "images", fs::copy_options::recursive);
  Run::wait_until([&] { return has_said(run, "Ctrl-C saves the model"); });
  run.send(SIGINT);
  const Outcome outcome = run.wait();
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  CHECK(nlohmann::json::parse(outcome.out)["views"]["stored"] > 0);
  CHECK(options_beside(out)["watch"] == true);
  CHECK(lumatlas_here({"inspect", out.string(), "--quiet"}).status == 0);
  // What is already there when it starts, quietly, with an end of its own.
  const Outcome idle = lumatlas({"build", scene.string(), kLargeCells, "-o", out.string(), "--watch", "--idle", "1",
                                 "--refine", "none", "--json", "--quiet"});
  CHECK(idle.status == 0);
  CHECK(idle.err.empty());
  CHECK(nlohmann::json::parse(idle.out)["views"]["offered"] == 12);
}

TEST_CASE("build --view --quiet says its address on stdout, and nothing on stderr") {
  const TemporaryFolder folder;
  const Run run({"build", made().scene, kLargeCells, "-o", (folder / "out").string(), "--refine", "none", "--view",
                 "--no-browser", "--quiet"});
  Run::wait_until([&] { return run.out().find("on disk") != std::string::npos; });
  run.send(SIGINT);
  const Outcome outcome = run.wait();
  CHECK(outcome.status == -SIGINT);
  CHECK(outcome.err.empty());
  CHECK(outcome.out.starts_with("http://127.0.0.1:"));
}

TEST_CASE("a scene without a mesh: the line that build names makes one, which build then finds") {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene").string(), model = (folder / "model").string();
  fs::copy(made().scene, scene, fs::copy_options::recursive);
  fs::remove(folder / "scene/mesh.ply");
  check_failure(lumatlas_here({"build", scene, "-o", model}),
                "`lumatlas mesh " + scene + " -o " + scene + "/mesh.ply`");
  const Outcome meshed = lumatlas_here({"mesh", scene, "-o", scene + "/mesh.ply", "--quiet"});
  REQUIRE(meshed.status == 0);
  CHECK(meshed.err.empty());
  CHECK_THAT(meshed.out, Catch::StartsWith(scene + "/mesh.ply: ") && Catch::Contains("of the points lie on it"));
  CHECK(lumatlas_here({"build", scene, kLargeCells, "-o", model, "--quiet"}).status == 0);
  const std::string bytes = bytes_of(scene + "/mesh.ply");
  CHECK(lumatlas_here({"mesh", scene, "-o", scene + "/mesh.ply", "--quiet"}).status == 0);
  CHECK(bytes_of(scene + "/mesh.ply") == bytes);
}

TEST_CASE("mesh refuses an output that is no PLY, that is its points, or that cannot be written, and leaves nothing") {
  const TemporaryFolder folder;
  const std::string scene = made().scene;
  CHECK(lumatlas_here({"mesh", scene, "-o", (folder / "mesh.obj").string()}).status == 2);
  CHECK(lumatlas_here({"mesh", scene, "-o", (folder / "mesh.ply").string(), "--spacing", "-1"}).status == 2);
  CHECK(lumatlas_here({"mesh", scene, "-o", (folder / "mesh.ply").string(), "--set", "cut.noise=nan"}).status == 2);
  const std::string mesh = scene + "/mesh.ply", bytes = bytes_of(mesh);
  CHECK(lumatlas_here({"mesh", scene, "-o", mesh, "--points", mesh}).status == 1);
  CHECK(bytes_of(mesh) == bytes);
  check_failure(lumatlas_here({"mesh", scene, "-o", (folder / "no/mesh.ply").string()}), "no");
  check_failure(lumatlas_here({"mesh", (folder / "nowhere").string(), "-o", (folder / "mesh.ply").string()}),
                "nowhere");
  CHECK(names_in(folder.path()).empty());
}

TEST_CASE("a mistyped command or option gets the name of the nearest one") {
  const auto says = [](const Arguments& arguments, const std::string& sentence) {
    const Outcome outcome = lumatlas_here(arguments);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.err, Catch::EndsWith(sentence + "\n"));
  };
  says({"biuld", "scene"}, "There is no command biuld; did you mean build?");
  says({"frobnicate"}, "There is no command frobnicate.");
  says({"build", "scene", "-o", "x", "--max-vews=3"}, "There is no option --max-vews; did you mean --max-views?");
  says({"render", "model", "-o", "x", "--suprsample", "3"},
       "There is no option --suprsample; did you mean --supersample?");
  CHECK_THAT(lumatlas_here({"build", "scene", "-o", "x", "--zzzzzz"}).err, !Catch::Contains("did you mean"));
  CHECK_THAT(lumatlas_here({"--version"}).err, Catch::Equals(""));
}

TEST_CASE("inspect tells of cameras and photographs also without a mesh, and how to get one") {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene").string();
  fs::copy(made().scene, scene, fs::copy_options::recursive);
  fs::remove(folder / "scene/mesh.ply");
  const Outcome outcome = lumatlas_here({"inspect", scene, "--json", "--quiet"});
  REQUIRE(outcome.status == 0);
  const nlohmann::json read = nlohmann::json::parse(outcome.out);
  CHECK(read["mesh"].is_null());
  CHECK(read["views"]["count"] == 12);
  CHECK(read["views"]["lenses"] == nlohmann::json{{"PINHOLE 64x48", 12}});
  CHECK_THAT(read["warnings"].at(0).get<std::string>(), Catch::Contains("`lumatlas mesh " + scene));
  CHECK_THAT(lumatlas_here({"inspect", scene}).out, Catch::StartsWith("mesh       none\nviews      12, COLMAP\n"));
  check_failure(lumatlas_here({"inspect", (folder / "nowhere").string()}), "nowhere");
}

TEST_CASE("jpg is jpeg") {
  const TemporaryFolder folder;
  const Outcome outcome = lumatlas({"build", made().scene, kLargeCells, "-o", (folder / "model").string(), "--image",
                                    "jpg", "--refine", "none", "--quiet"});
  INFO(outcome.err);
  CHECK(outcome.status == 0);
}

}  // namespace
}  // namespace lumatlas
