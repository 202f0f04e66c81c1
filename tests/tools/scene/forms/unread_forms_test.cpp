// SPDX-License-Identifier: GPL-3.0-or-later
// Folders that hold no form of capture that is read: what is there is named, with what to do.
#include "tools/scene/forms/unread_forms.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tools/scene/scene.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using test::write_file;

std::string refusal_of_views(const fs::path& scene) {
  try {
    (void)read_scene_views(scene, glm::dvec3(0));
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

std::string refusal_of_mesh(const fs::path& scene) {
  try {
    (void)find_mesh(scene, std::nullopt);
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

TEST_CASE("a folder of photographs alone names the command that finds out where they were taken") {
  for (const std::string folder : {"", "images/"}) {
    const TemporaryFolder scene;
    CHECK(unread_form_hint(scene.path()).empty());
    for (const char* const name : {"a.jpg", "b.JPG"}) write_file(scene / (folder + name), "is not looked at");
    const std::string photographs = folder.empty() ? scene.path().string() : (scene / "images").string();
    const std::string hint =
        "; it holds 2 photographs: `lumatlas capture " + photographs + "` finds out where they were taken";
    CHECK(unread_form_hint(scene.path()) == hint);
    CHECK_THAT(refusal_of_views(scene.path()),
               Catch::StartsWith(scene.path().string() + ": holds no COLMAP model") && Catch::EndsWith(hint));
    CHECK(refusal_of_mesh(scene.path()) == refusal_of_views(scene.path()));
  }
}

TEST_CASE("a form that is not read is named, and the forms that are") {
  const std::vector<std::pair<std::string, std::string>> forms{
      {"scene.nvm", "VisualSFM"},  {"sfm_data.bin", "OpenMVG"}, {"scan.sfm", "Meshroom"}, {"cameras.abc", "Meshroom"},
      {"office.psx", "Metashape"}, {"scene.mvs", "OpenMVS"},    {"scan.sens", "ScanNet"}, {"capture.r3d", "Record3D"}};
  for (const auto& [file, program] : forms) {
    CAPTURE(file);
    const TemporaryFolder scene;
    write_file(scene / "images/a.jpg", "is not looked at");
    write_file(scene / file, "MVS");
    const std::string sentence = refusal_of_views(scene.path());
    CHECK_THAT(sentence, Catch::Contains("; it holds " + file + " of " + program) &&
                             Catch::Contains("which is not read: export COLMAP's form (COLMAP, transforms.json, "));
    CHECK(refusal_of_mesh(scene.path()) == sentence);
  }
}

TEST_CASE("a CSV of cameras with other columns says which columns are expected") {
  const std::vector<std::string> heads{"#name,x,y,alt,heading,pitch,roll,focal\n", "name,x,y,alt,omega,pitch,roll,f\n"};
  for (const std::string& head : heads) {
    const TemporaryFolder scene;
    write_file(scene / "cameras.csv", head);
    CHECK_THAT(
        refusal_of_views(scene.path()),
        Catch::Contains("; cameras.csv looks like cameras of RealityCapture, whose columns must be name, x, y, alt, "
                        "heading, pitch, roll and f: "));
  }
}

TEST_CASE("a mesh under another name is named where none is found") {
  const TemporaryFolder scene;
  write_file(scene / "transforms.json", "{}");
  CHECK_THAT(refusal_of_mesh(scene.path()), Catch::Contains("texturedMesh): name one with --mesh"));
  write_file(scene / "office_scan.ply", "ply");
  CHECK_THAT(refusal_of_mesh(scene.path()),
             Catch::Contains("texturedMesh); there is office_scan.ply: name one with --mesh"));
}

}  // namespace
}  // namespace lumatlas
