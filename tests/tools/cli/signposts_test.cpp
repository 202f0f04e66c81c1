// SPDX-License-Identifier: GPL-3.0-or-later
// What the program says to people who are on the way to something else: the command or option that does it.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"

namespace lumatlas {
namespace {

TEST_CASE("build, inspect and mesh of photographs alone name capture") {
  const TemporaryFolder folder;
  for (const char* const name : {"a.jpg", "b.jpg", "c.png"}) (void)folder.with_file(name, "is not looked at");
  const std::string photographs = folder.path().string();
  const std::string capture = "`lumatlas capture " + photographs + "` finds out where they were taken";
  check_failure(lumatlas_here({"build", photographs, "-o", (folder / "model").string()}), capture);
  check_failure(lumatlas_here({"inspect", photographs}), "it holds 3 photographs: " + capture);
  check_failure(lumatlas_here({"mesh", photographs, "-o", (folder / "mesh.ply").string()}), capture);
}

TEST_CASE("a form that is not read is named with those that are") {
  const TemporaryFolder folder;
  (void)folder.with_file("office.psx", "x");
  const Outcome outcome = lumatlas_here({"inspect", folder.path().string()});
  check_failure(outcome, "it holds office.psx of Metashape");
  CHECK_THAT(outcome.err, Catch::Contains("Metashape, RealityCapture, OpenMVS, OpenSfM"));
}

TEST_CASE("validate without a scene says which one it needs and how to name it") {
  const Outcome outcome = lumatlas_here({"validate", made().model});
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.err, Catch::Contains("--views: must name the scene that the model was built from") &&
                              Catch::Contains("`lumatlas validate " + made().model + " --views SCENE`"));
}

TEST_CASE("export to a name of another form names the option for it") {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& name) {
    const Outcome outcome = lumatlas_here({"export", made().model, "-o", (folder / name).string()});
    CHECK(outcome.status == 2);
    return outcome.err;
  };
  CHECK_THAT(refused("x.obj"), Catch::Contains("for OBJ, `--to obj -o x` writes a folder with scene.obj"));
  CHECK_THAT(refused("x.gltf"), Catch::Contains("for glTF in files, `--to gltf -o x` writes a folder"));
  CHECK_THAT(refused("x.html"), Catch::Contains("for a page, --to web writes x.html"));
  CHECK_THAT(refused("x.stl"), Catch::Contains("must end in .glb with --to glb"));
  CHECK(names_in(folder.path()).empty());
}

TEST_CASE("--watch and --view are in the help of build") {
  const std::string help = lumatlas_here({"build", "--help"}).out;
  CHECK_THAT(help, Catch::Contains("\n  --watch ") && Catch::Contains("\n  --view "));
}

}  // namespace
}  // namespace lumatlas
