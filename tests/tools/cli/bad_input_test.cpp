// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes that are not as they should be, where the user says to go on.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "mesh/readers/mesh_file.h"
#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"

namespace lumatlas {
namespace {

using nlohmann::json;

// A copy of the common scene whose photograph 0001 is not there, and whose 0004 and 0005 end in the middle.
struct Damaged {
  TemporaryFolder folder;
  std::string scene = (folder / "scene").string();
  Damaged() {
    fs::copy(made().scene, scene, fs::copy_options::recursive);
    fs::remove(scene + "/images/0001.png");
    for (const char* const name : {"0004", "0005"}) {
      const fs::path file = scene + "/images/" + name + ".png";
      fs::resize_file(file, fs::file_size(file) / 2);
    }
  }
  [[nodiscard]] Arguments build(const std::string& output) const {
    return {"build", scene, kLargeCells, "-o", output, "--hold", "4", "--refine", "none", "--json", "--quiet"};
  }
};

TEST_CASE("a photograph that is missing stops a build, unless it is to go on without bad ones") {
  const Damaged damaged;
  const std::string model = (damaged.folder / "model").string();
  check_failure(lumatlas_here(damaged.build(model)), "0001.png: no such photograph");
  CHECK_FALSE(fs::exists(model));

  Arguments skipping = damaged.build(model);
  skipping.push_back("--skip-bad");
  const Outcome outcome = lumatlas_here(skipping);
  REQUIRE(outcome.status == 0);
  CHECK_THAT(outcome.err, Catch::Contains("warning: 3 of 12 photographs are left out") &&
                              Catch::Contains("0001.png: no such photograph") && Catch::Contains("0004.png: ") &&
                              Catch::Contains("0005.png: "));
  const json views = json::parse(outcome.out)["views"];
  CHECK(views["skipped"] == json{"0001.png", "0004.png", "0005.png"});
  // Of 12, ranks 0, 4 and 8 are held out, as if nothing were bad; 1 and 5 are bad.
  CHECK(views["offered"] == 7);
}

TEST_CASE("a model that was built without bad photographs is scored and drawn without them") {
  const Damaged damaged;
  const std::string model = (damaged.folder / "model").string();
  Arguments skipping = damaged.build(model);
  skipping.push_back("--skip-bad");
  REQUIRE(lumatlas_here(skipping).status == 0);
  const Outcome scored = lumatlas_here({"validate", model, "--views", damaged.scene, "--no-pictures", "--no-alignment",
                                        "--baselines", "unbounded", "--json", "--quiet"});
  if (scored.err.find("no OpenGL 4.5") != std::string::npos) {
    WARN("skipped: " << scored.err);
    return;
  }
  INFO(scored.err);
  REQUIRE(scored.status == 0);
  const json scores = json::parse(scored.out);
  std::set<std::string> names;
  for (const json& view : scores["views"]) names.insert(view["name"]);
  CHECK(names == std::set<std::string>{"0000.png", "0008.png"});
  const fs::path drawn = damaged.folder / "drawn";
  CHECK(lumatlas_here({"render", model, "--views", damaged.scene, "-o", drawn.string(), "--quiet"}).status == 0);
  CHECK(names_in(drawn).size() == 9 + 1);  // and lumatlas.json
}

TEST_CASE("where every photograph is bad there is nothing to go on with") {
  const Damaged damaged;
  for (const auto& entry : fs::directory_iterator(damaged.scene + "/images")) fs::resize_file(entry.path(), 9);
  Arguments skipping = damaged.build((damaged.folder / "model").string());
  skipping.push_back("--skip-bad");
  check_failure(lumatlas_here(skipping), "none of its 12 photographs can be used; the first: ");
}

TEST_CASE("a wrong mesh is refused, unless any mesh is to do, and then it is warned of as inspect warns") {
  const TemporaryFolder folder;
  const std::string far = (folder / "far.ply").string();
  write_ply(far, {{{900, 900, 900}, {901, 900, 900}, {900, 901, 900}}, {}, {{0, 1, 2}}});
  const std::string model = (folder / "model").string();
  Arguments build{"build",  made().scene,
                  "--mesh", far,
                  "-o",     model,
                  "--set",  "coverage.demand=off",
                  "--set",  "coverage.ideal-distance=1",
                  "--quiet"};
  check_failure(lumatlas_here(build), "--any-mesh builds all the same");
  build.push_back("--any-mesh");
  const Outcome outcome = lumatlas_here(build);
  INFO(outcome.err);
  CHECK(outcome.status == 1);  // a model of no photograph is none
  CHECK_THAT(outcome.err,
             Catch::Contains("warning: 12 of 12 views see next to nothing of the mesh, the first is 0000.png") &&
                 Catch::Contains("12 see nothing of the mesh"));
  CHECK_FALSE(fs::exists(model));
}

}  // namespace
}  // namespace lumatlas
