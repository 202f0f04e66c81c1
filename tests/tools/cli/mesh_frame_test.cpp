// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes in another frame than the poses: what the program says of them, followed to the letter.
#include <catch2/catch.hpp>
#include <fstream>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "mesh/readers/mesh_file.h"
#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"

namespace lumatlas {
namespace {

using nlohmann::json;

void write_soup(const std::string& path, const TriangleSoup& soup) {
  std::ofstream file(path, std::ios::binary);
  write_ply(file, soup);
}

// The options that a sentence says to give: the words behind the first "give ", as long as they are options and values.
Arguments options_to_give(const std::string& sentence) {
  std::istringstream words(sentence.substr(sentence.find("give --mesh") + 5));
  Arguments options;
  for (std::string word; words >> word && word.front() != '(';) options.push_back(word);
  return options;
}

// A scene with photographs that can be compared, larger than that of the other tests of the program.
const std::string& framed_scene() {
  static const TemporaryFolder folder;
  static const std::string scene = (folder / "scene").string();
  static const Outcome synth =
      lumatlas_here({"synth", "apartment", "-o", scene, "--photographs", "12", "--width", "120", "--height", "120",
                     "--samples", "4", "--triangles", "4000", "--quiet"});
  REQUIRE(synth.status == 0);
  return scene;
}

Arguments build_of(const std::string& mesh, const std::string& model) {
  return {"build", framed_scene(), "--mesh", mesh, "-o", model, "--hold", "4", "--texture", "none", "--quiet"};
}

// The raw PSNR of the model over whole frames; none without OpenGL.
std::optional<double> score_of(const std::string& model) {
  const Outcome scored = lumatlas_here({"validate", model, "--views", framed_scene(), "--no-pictures", "--no-alignment",
                                        "--baselines", "none", "--json", "--quiet"});
  if (scored.err.find("no OpenGL 4.5") != std::string::npos) return std::nullopt;
  INFO(scored.err);
  REQUIRE(scored.status == 0);
  return json::parse(scored.out)["methods"]["store"]["frame"]["raw"]["psnr"].get<double>();
}

struct FrameCase {
  const char* name;
  glm::dmat3 linear;
  glm::dvec3 shift;
  const char* told;
};

std::vector<FrameCase> frame_cases() {
  const glm::dmat3 one(1.0), to_y_up(1, 0, 0, 0, 0, -1, 0, 1, 0), mirror(-1, 0, 0, 0, 1, 0, 0, 0, 1);
  const glm::dvec3 none(0);
  return {{"millimetres", 1000.0 * one, none, "--mesh-scale 0.001 "},
          {"y up", to_y_up, none, "--mesh-axes x,-z,y "},
          {"both", 1000.0 * to_y_up, none, "--mesh-scale 0.001 --mesh-axes x,-z,y "},
          {"map", one, {500000, 4500000, 100}, "--mesh-shift -500000,-4500000,-100 "},
          {"mirrored", mirror, none, "--mesh-axes -x,y,z "}};
}

TEST_CASE("what build and inspect say of a mesh in another frame makes it as good as the mesh in the right one") {
  const TemporaryFolder folder;
  const std::string scene_mesh = framed_scene() + "/mesh.ply", right = (folder / "right").string();
  REQUIRE(lumatlas_here(build_of(scene_mesh, right)).status == 0);
  const std::optional<double> right_score = score_of(right);
  for (const FrameCase& c : frame_cases()) {
    CAPTURE(c.name);
    TriangleSoup soup = read_triangle_soup(scene_mesh);
    for (glm::dvec3& position : soup.positions) position = c.linear * position + c.shift;
    const std::string mesh = (folder / (std::string(c.name) + ".ply")).string(), model = (folder / c.name).string();
    write_soup(mesh, soup);
    const Outcome refused = lumatlas_here(build_of(mesh, model));
    CAPTURE(refused.err);
    CHECK(refused.status == 1);
    CHECK_FALSE(fs::exists(model));
    CHECK_THAT(refused.err, Catch::Contains(mesh + ": does not fit the photographs") &&
                                Catch::Contains(std::string("give ") + c.told));
    const Outcome seen = lumatlas_here({"inspect", framed_scene(), "--mesh", mesh, "--json", "--quiet"});
    CHECK(seen.status == 0);
    const json remedy = json::parse(seen.out)["fit"]["remedy"];
    REQUIRE(remedy.is_object());
    Arguments again = build_of(mesh, model);
    const Arguments options = options_to_give(refused.err);
    again.insert(again.end(), options.begin(), options.end());
    const Outcome built = lumatlas_here(again);
    CHECK(built.status == 0);
    CHECK(built.err.empty());
    const json noted = options_beside(model);
    for (const auto& [key, value] : remedy.items()) CHECK(noted[key] == value);
    if (right_score) CHECK(*score_of(model) == Approx(*right_score).margin(0.05));  // dB: floats of other sizes
  }
}

TEST_CASE("a mesh in another frame is built as it is if that is what its options say, and warned of") {
  const TemporaryFolder folder;
  TriangleSoup soup = read_triangle_soup(framed_scene() + "/mesh.ply");
  for (glm::dvec3& position : soup.positions) position *= 1000;
  const std::string mesh = (folder / "large.ply").string();
  write_soup(mesh, soup);
  for (const Arguments& as_it_is : {Arguments{"--mesh-scale", "1"}, Arguments{"--any-mesh"}}) {
    CAPTURE(as_it_is.front());
    Arguments build = build_of(mesh, (folder / "model").string());
    build.insert(build.end(), as_it_is.begin(), as_it_is.end());
    const Outcome outcome = lumatlas_here(build);
    INFO(outcome.err);
    CHECK(outcome.status == 0);
    CHECK_THAT(outcome.err, Catch::Contains("warning: " + mesh + ": does not fit the photographs"));
  }
}

TEST_CASE("mesh --complete takes the frame too, and writes the mesh in that of the poses") {
  const TemporaryFolder folder;
  TriangleSoup soup = read_triangle_soup(framed_scene() + "/mesh.ply");
  const Bounds right = bounds(soup);
  for (glm::dvec3& position : soup.positions) position = 1000.0 * position;
  const std::string mesh = (folder / "large.ply").string(), output = (folder / "completed.ply").string();
  write_soup(mesh, soup);
  const Arguments complete{"mesh",   framed_scene(), "-o",           output,  "--complete", mesh,
                           "--from", "points",       "--mesh-scale", "0.001", "--quiet"};
  REQUIRE(lumatlas_here(complete).status == 0);
  const Bounds found = bounds(read_triangle_soup(output));
  for (int i = 0; i < 3; ++i) {
    CHECK(found.min[i] == Approx(right.min[i]).margin(0.01));  // points lie on the surface
    CHECK(found.max[i] == Approx(right.max[i]).margin(0.01));
  }
}

TEST_CASE("frames that cannot be are wrong usage, in each command and before anything is read") {
  const auto check_usage = [](Arguments arguments, const std::string& sentence) {
    const Outcome outcome = lumatlas_here(arguments);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.err, Catch::StartsWith(sentence));
  };
  check_usage({"build", "none", "-o", "model", "--mesh-axes", "x,y,y"}, "--mesh-axes: x,y,y names y twice: ");
  check_usage({"build", "none", "-o", "model", "--mesh-scale", "0"}, "--mesh-scale: 0 is not a finite number above 0");
  check_usage({"inspect", "none", "--mesh-shift", "1,2"}, "--mesh-shift: 1,2 is not three numbers: ");
  check_usage({"mesh", "none", "-o", "mesh.ply", "--mesh-scale", "2"}, "--mesh-scale requires --complete");
  check_usage({"inspect", made().model, "--mesh-scale", "2"}, "--mesh-scale: is for scenes");
}

}  // namespace
}  // namespace lumatlas
