// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/errors/disturbance.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <glm/glm.hpp>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "tests/support/scenes/synth_files.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/synth/synth.h"
#include "tools/scene/forms/colmap/colmap.h"

namespace lumatlas {
namespace {

SynthOptions walk_options() {
  SynthOptions options;
  options.views = 6;
  options.width = 48;
  options.height = 36;
  options.samples = 2;
  options.triangles = 5000;
  return options;
}

SynthOptions everything_disturbed() {
  SynthOptions options = walk_options();
  options.disturbances = {1.5, 0.7, 0.3, 0.34, 0.5, 0.4, 3, 2, 0.01, 0.05, 0.5};
  return options;
}

using Files = std::map<std::string, std::string>;

nlohmann::json json_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return nlohmann::json::parse(file);
}

// An undisturbed scene of the options and what belongs to it.
struct Made {
  explicit Made(const SynthOptions& options)
      : scene(synth::make_apartment(options.seed, options.triangles)),
        cameras(synth::cameras_on_walk(scene, options)),
        tracer(scene),
        views(synth::disturb(scene, tracer, cameras, options)) {}
  synth::Scene scene;
  std::vector<Camera> cameras;
  synth::Tracer tracer;
  std::vector<synth::Disturbance> views;
};

bool same_pose(const Camera& a, const Camera& b) {
  return a.cam_from_world_rotation == b.cam_from_world_rotation &&
         a.cam_from_world_translation == b.cam_from_world_translation;
}

double angle_between_deg(const Camera& a, const Camera& b) {
  const glm::dmat3 between = a.cam_from_world_rotation * glm::transpose(b.cam_from_world_rotation);
  return glm::degrees(std::acos((between[0][0] + between[1][1] + between[2][2] - 1) / 2));
}

TEST_CASE("a disturbed scene has the same bytes for any number of threads") {
  CHECK((written(everything_disturbed(), 1) == written(everything_disturbed(), 4)));
}

TEST_CASE("pose noise changes the written poses alone, and the true ones are beside them") {
  SynthOptions options = walk_options();
  const Files undisturbed = written(options, 4);
  options.disturbances.pose_noise = 2;
  Files files = written(options, 4);
  CHECK(files.at("sparse/images.bin") != undisturbed.at("sparse/images.bin"));
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    CHECK(files.at(std::string("truth/sparse/") + name) == undisturbed.at(std::string("sparse/") + name));
  }
  for (const auto& [name, bytes] : undisturbed) {
    INFO(name);
    CHECK(files.count(name) == 1);
    if (name != "sparse/images.bin") CHECK((files[name] == bytes));
  }
  CHECK(files.size() == undisturbed.size() + 4);  // the model and disturbances.json
}

TEST_CASE("exposure noise changes photographs and the colours of points, not poses") {
  SynthOptions options = walk_options();
  const Files undisturbed = written(options, 4);
  options.disturbances.exposure_noise = 1;
  const Files files = written(options, 4);
  CHECK(files.at("sparse/images.bin") == undisturbed.at("sparse/images.bin"));
  CHECK(files.at("truth/sparse/images.bin") == undisturbed.at("sparse/images.bin"));
  CHECK(files.at("images/0000.png") != undisturbed.at("images/0000.png"));
}

// ---- Poses.

TEST_CASE("pose noise displaces what a view sees by the pixels asked for, root mean square") {
  for (const double asked : {0.25, 3.0, 6.0}) {
    SynthOptions options = walk_options();
    options.disturbances.pose_noise = asked;
    const Made made(options);
    for (std::size_t i = 0; i < made.views.size(); ++i) {
      double sum = 0;
      double count = 0;
      for (double y = 0.5; y < options.height; ++y) {
        for (double x = 0.5; x < options.width; ++x) {
          const auto point = made.tracer.surface_at(made.cameras[i], {x, y});
          REQUIRE(point);
          const Camera& written = made.views[i].written;
          const glm::dvec2 shift = written.image_from_cam(written.cam_from_world(*point)) - glm::dvec2(x, y);
          sum += glm::dot(shift, shift);
          ++count;
        }
      }
      CHECK(std::sqrt(sum / count) == Approx(asked).epsilon(0.05));  // other points than those of the noise's own grid
      CHECK(made.views[i].displacement_px == Approx(asked).epsilon(1e-9));
      CHECK_FALSE(made.views[i].wrong);
      CHECK_NOTHROW(check(made.views[i].written));
    }
  }
}

TEST_CASE("pose noise turns and shifts every view differently, and another seed otherwise") {
  SynthOptions options = walk_options();
  options.disturbances.pose_noise = 2;
  const Made one(options);
  options.seed = 2;
  const Made other(options);
  std::set<double> turns;
  for (std::size_t i = 0; i < one.views.size(); ++i) {
    const double turn = angle_between_deg(one.views[i].written, one.cameras[i]);
    CHECK(turn > 0.3);  // half of 2 px of 36 px to a radian is 1.6 degrees
    CHECK(glm::distance(one.views[i].written.center(), one.cameras[i].center()) > 0.005);
    turns.insert(turn);
    CHECK(turn != angle_between_deg(other.views[i].written, other.cameras[i]));
  }
  CHECK(turns.size() == one.views.size());
}

TEST_CASE("the written files hold the disturbed poses and say by how much they are wrong") {
  const TemporaryFolder folder;
  const SynthOptions options = everything_disturbed();
  write_synthetic_scene(options, folder.path());
  const Made made(options);
  const ColmapModel noisy = read_colmap_model(folder.path());
  const ColmapModel truth = read_colmap_model(folder / "truth");
  const nlohmann::json json = json_of(folder / "truth/disturbances.json");
  CHECK(json.at("vignetting") == 0.4);
  REQUIRE(json.at("views").size() == options.views);
  REQUIRE(noisy.images.size() == options.views);
  for (std::size_t i = 0; i < options.views; ++i) {
    CHECK(noisy.images[i].id == truth.images[i].id);
    CHECK(noisy.images[i].camera_id == truth.images[i].camera_id);
    CHECK(noisy.images[i].name == truth.images[i].name);
    const glm::dmat3 turned = glm::mat3_cast(noisy.images[i].cam_from_world_rotation);
    for (int k = 0; k < 3; ++k)
      CHECK(glm::length(turned[k] - made.views[i].written.cam_from_world_rotation[k]) < 1e-12);
    CHECK(glm::length(truth.images[i].cam_from_world_translation - made.cameras[i].cam_from_world_translation) < 1e-12);
    const nlohmann::json& view = json.at("views").at(noisy.images[i].name);
    CHECK(view.at("wrong") == made.views[i].wrong);
    CHECK(view.at("rotation_deg").get<double>() ==
          Approx(angle_between_deg(made.views[i].written, made.cameras[i])).epsilon(1e-6));
    CHECK(view.at("translation").get<double>() ==
          Approx(glm::distance(made.views[i].written.center(), made.cameras[i].center())));
    for (int channel = 0; channel < 3; ++channel)
      CHECK(view.at("gain").at(channel) == made.views[i].exposure.gain[channel]);
    const bool has_mask = std::filesystem::exists(folder / ("truth/masks/" + noisy.images[i].name));
    CHECK(has_mask == made.views[i].passer_by.has_value());
    CHECK(has_mask == view.contains("passer_by"));
    if (!made.views[i].wrong) CHECK(view.at("displacement_px").get<double>() == Approx(1.5));
  }
}

TEST_CASE("the share of plainly wrong poses is exact, and the others are true") {
  for (const auto& [share, expected] :
       {std::pair{0.3, 6}, std::pair{0.32, 6}, std::pair{0.33, 7}, std::pair{1.0, 20}}) {
    SynthOptions options = walk_options();
    options.views = 20;
    options.disturbances.wrong_poses = share;
    const Made made(options);
    int wrong = 0;
    for (std::size_t i = 0; i < made.views.size(); ++i) {
      const Camera& camera = made.views[i].written;
      if (!made.views[i].wrong) {
        CHECK(same_pose(camera, made.cameras[i]));
        continue;
      }
      ++wrong;
      CHECK_NOTHROW(check(camera));
      const double angle = angle_between_deg(camera, made.cameras[i]);
      CHECK((angle > 9.99 && angle < 30.01));
      const double moved = glm::distance(camera.center(), made.cameras[i].center());
      const double diameter = glm::length(glm::dvec3(8.8, 4.4, 2.6));  // from the far corner to the windows' panes
      CHECK((moved > 0.049 * diameter && moved < 0.151 * diameter));
      CHECK(synth::is_free(made.scene, made.tracer, camera.center(), 0.2));
    }
    CHECK(wrong == expected);
  }
}

TEST_CASE("a ball is free in the open, not in a wall, in furniture or through the floor") {
  const Made made(walk_options());
  CHECK(synth::is_free(made.scene, made.tracer, {4.3, 2.5, 1.5}, 0.3));
  CHECK_FALSE(synth::is_free(made.scene, made.tracer, {5.27, 0.5, 1.5}, 0.01));
  CHECK_FALSE(synth::is_free(made.scene, made.tracer, {2.4, 0.46, 0.2}, 0.01));
  CHECK_FALSE(synth::is_free(made.scene, made.tracer, {4.3, 2.5, 0.2}, 0.3));
}

TEST_CASE("displacement is that of a pinhole camera, and infinite for what is behind") {
  Camera camera;
  camera.width = 40;
  camera.height = 30;
  camera.fx = 20;
  camera.fy = 10;
  Camera shifted = camera;
  shifted.cam_from_world_translation = {0.1, 0, 0};
  const std::vector<glm::dvec3> points{{0, 0, 2}, {1, 1, 4}};
  CHECK(synth::displacement_px(camera, camera, points) == 0);
  CHECK(synth::displacement_px(camera, shifted, points) == Approx(std::sqrt((1 + 0.25) / 2)));
  CHECK(synth::displacement_px(camera, shifted, {}) == 0);
  shifted.cam_from_world_translation = {0, 0, -2};
  CHECK(synth::displacement_px(camera, shifted, points) == std::numeric_limits<double>::infinity());
}

// ---- Exposures.

TEST_CASE("gains stay within the stops asked for and fill that range") {
  SynthOptions options = walk_options();
  options.views = 400;
  options.disturbances.exposure_noise = 1.5;
  options.disturbances.white_balance_noise = 0.5;
  const Made made(options);
  for (const int channel : {0, 2}) {
    double low = 9;
    double high = -9;
    for (const synth::Disturbance& view : made.views) {
      const glm::vec3& gain = view.exposure.gain;
      CHECK(std::abs(std::log2(gain.y)) <= 1.5F);
      const double balance = std::log2(gain[channel] / gain.y);
      low = std::min(low, balance);
      high = std::max(high, balance);
    }
    CHECK((low >= -0.50001 && low < -0.48));
    CHECK((high <= 0.50001 && high > 0.48));
  }
}

// Mean over a channel's values that are neither dark nor near white in either photograph, of the second's light over
// that of the first.
double light_ratio(const Photograph& a, const Photograph& b, int channel) {
  const auto usable = [](int value) { return value > 40 && value < 250; };
  double sum_a = 0;
  double sum_b = 0;
  for (std::size_t i = static_cast<std::size_t>(channel); i < a.rgb.size(); i += 3) {
    if (!usable(a.rgb[i]) || !usable(b.rgb[i])) continue;
    sum_a += synth::linear_from_srgb(a.rgb[i], 0, 0).x;
    sum_b += synth::linear_from_srgb(b.rgb[i], 0, 0).x;
  }
  REQUIRE(sum_a > 10);
  return sum_b / sum_a;
}

TEST_CASE("photographs differ by their gains where they are not clipped") {
  const TemporaryFolder plain;
  const TemporaryFolder disturbed;
  SynthOptions options = walk_options();
  write_synthetic_scene(options, plain.path());
  options.disturbances.exposure_noise = 0.8;
  options.disturbances.white_balance_noise = 0.3;
  write_synthetic_scene(options, disturbed.path());
  const nlohmann::json json = json_of(disturbed / "truth/disturbances.json");
  for (const auto& [name, view] : json.at("views").items()) {
    const Photograph a = read_photograph(plain / ("images/" + name));
    const Photograph b = read_photograph(disturbed / ("images/" + name));
    for (int channel = 0; channel < 3; ++channel) {
      CHECK(light_ratio(a, b, channel) == Approx(view.at("gain").at(channel).get<double>()).epsilon(0.01));  // 8 bits
    }
  }
}

TEST_CASE("what a higher exposure takes beyond white is lost") {
  const Made made(walk_options());
  const Camera& camera = made.cameras[1];
  const Photograph plain = made.tracer.photograph(camera, 2, 1);
  const Photograph bright = made.tracer.photograph(camera, 2, 1, {glm::vec3(4), 0});
  for (std::size_t i = 0; i < plain.rgb.size(); ++i) {
    if (plain.rgb[i] > 138) CHECK(bright.rgb[i] == 255);  // linear light 0.255
    if (plain.rgb[i] < 136) CHECK(bright.rgb[i] < 255);   // 0.246
  }
}

TEST_CASE("vignetting takes the share asked for from the corners and nothing from the principal point") {
  const Made made(walk_options());
  Camera camera = made.cameras[1];
  camera.cx += 5;
  const Photograph plain = made.tracer.photograph(camera, 4, 1);
  const Photograph dim = made.tracer.photograph(camera, 4, 1, {glm::vec3(1), 0.6});
  for (std::size_t i = 0; i < plain.rgb.size(); ++i) {
    if (plain.rgb[i] == 255) continue;
    const glm::dvec2 at(static_cast<double>(i / 3 % 48) + 0.5, static_cast<double>(i / 3 / 48) + 0.5);
    const double r = glm::distance(at, {camera.cx, camera.cy}) / 30;  // half of the diagonal of 48 x 36
    const double light = synth::linear_from_srgb(plain.rgb[i], 0, 0).x * (1 - 0.6 * r * r);
    CHECK(std::abs(dim.rgb[i] - synth::srgb_from_linear(static_cast<float>(light))) <= 1);
  }
}

// ---- The sensor and the shutter.

TEST_CASE("blur moves what a view sees by the pixels asked for, each view otherwise, and no pose") {
  SynthOptions options = walk_options();
  const Files undisturbed = written(options, 4);
  options.disturbances.blur = 3;
  const Made made(options);
  std::set<double> turns;
  for (std::size_t i = 0; i < made.views.size(); ++i) {
    CHECK(made.views[i].blur_px == Approx(3).epsilon(1e-9));
    CHECK(same_pose(made.views[i].written, made.cameras[i]));
    turns.insert(glm::length(made.views[i].exposure.motion.rotation));
  }
  CHECK(turns.size() == made.views.size());
  const Files files = written(options, 4);
  CHECK(files.at("sparse/images.bin") == undisturbed.at("sparse/images.bin"));
  CHECK(files.at("mesh.ply") == undisturbed.at("mesh.ply"));
  CHECK(files.at("images/0000.png") != undisturbed.at("images/0000.png"));
}

TEST_CASE("the sensor's noise is the same whatever else is disturbed, and not that of another view") {
  SynthOptions options = walk_options();
  options.disturbances.noise = 4;
  const Made made(options);
  for (const synth::Disturbance& view : made.views) CHECK(view.exposure.noise == 4);
  const Photograph clean = made.tracer.photograph(made.cameras[0], 2, 1);
  const Photograph one = made.tracer.photograph(made.cameras[0], 2, 1, {glm::vec3(1), 0, 4, {}});
  const Photograph other = made.tracer.photograph(made.cameras[0], 2, 2, {glm::vec3(1), 0, 4, {}});
  CHECK(one.rgb == made.tracer.photograph(made.cameras[0], 2, 1, {glm::vec3(1), 0, 4, {}}).rgb);
  CHECK(one.rgb != clean.rgb);
  CHECK(one.rgb != other.rgb);
}

// ---- Passers-by.

TEST_CASE("photographs differ where the mask of a passer-by is, and little elsewhere") {
  SynthOptions options = walk_options();
  options.views = 12;
  const Made plain(options);
  options.disturbances.passers_by = 0.5;
  const Made made(options);
  int count = 0;
  for (std::size_t i = 0; i < made.views.size(); ++i) {
    if (!made.views[i].passer_by) continue;
    ++count;
    const synth::PasserBy& person = *made.views[i].passer_by;
    const Photograph mask = made.tracer.mask(made.cameras[i], person.visitor);
    CHECK(synth::white_share(mask) == person.share);
    CHECK(person.share >= synth::kLeastPasserBy);
    const Photograph without = plain.tracer.photograph(plain.cameras[i], 4, 1);
    const Photograph with = made.tracer.photograph(made.cameras[i], 4, 1, {}, &person.visitor);
    double inside = 0;
    double changed_inside = 0;
    double outside = 0;
    double changed_outside = 0;
    for (std::size_t p = 0; p < mask.rgb.size(); p += 3) {
      int most = 0;
      for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(with.rgb[p + c] - without.rgb[p + c]));
      const bool changed = most > 20;
      (mask.rgb[p] == 255 ? inside : outside) += 1;
      if (changed) (mask.rgb[p] == 255 ? changed_inside : changed_outside) += 1;
    }
    CHECK(changed_inside > 0.97 * inside);
    CHECK(changed_outside < 0.06 * outside);  // shadows, reflections, edges
  }
  CHECK(count == 6);
}

TEST_CASE("passers-by stand at different places in different clothes") {
  SynthOptions options = walk_options();
  options.disturbances.passers_by = 1;
  options.views = 10;
  const Made made(options);
  std::set<double> shares;
  std::set<std::array<std::uint8_t, 3>> clothes;
  std::size_t people = 0;
  for (std::size_t i = 0; i < made.views.size(); ++i) {
    if (!made.views[i].passer_by) continue;
    ++people;
    const synth::Visitor& visitor = made.views[i].passer_by->visitor;
    const Photograph mask = made.tracer.mask(made.cameras[i], visitor);
    const Photograph photo = made.tracer.photograph(made.cameras[i], 1, 1, {}, &visitor);
    const auto first = static_cast<std::size_t>(std::find(mask.rgb.begin(), mask.rgb.end(), 255) - mask.rgb.begin());
    clothes.insert({photo.rgb[first], photo.rgb[first + 1], photo.rgb[first + 2]});
    shares.insert(made.views[i].passer_by->share);
  }
  CHECK(people >= 8);
  CHECK(clothes.size() == people);
  CHECK(shares.size() + 1 >= people);  // two may take up as many pixels by chance
}

// A hollow cube of this side on the floor z = 0, with the camera in its middle looking along x.
struct Chamber {
  explicit Chamber(double side) {
    synth::Block room;
    room.parts = {{{0, 0, 0}, {side, side, side}, {}}};
    room.hollow = true;
    scene.solids.emplace_back(room);
    scene.materials.resize(1);
    scene.geometry = synth::tessellate(scene.solids, 10);
    camera.width = camera.height = 64;
    camera.fx = camera.fy = camera.cx = camera.cy = 32;
    camera.cam_from_world_rotation = glm::transpose(glm::dmat3({0, -1, 0}, {0, 0, -1}, {1, 0, 0}));
    camera.cam_from_world_translation = -(camera.cam_from_world_rotation * glm::dvec3(side / 2));
  }
  synth::Scene scene;
  Camera camera;
};

TEST_CASE("a passer-by is found where there is room, and none where there is not") {
  const Chamber wide(6);
  CHECK(synth::find_passer_by(wide.scene, synth::Tracer(wide.scene), wide.camera, 1));
  const Chamber narrow(2);
  CHECK_FALSE(synth::find_passer_by(narrow.scene, synth::Tracer(narrow.scene), narrow.camera, 1));
}

// ---- Options.

TEST_CASE("a bad disturbance is refused by name, with the value and the rule") {
  CHECK_NOTHROW(check(everything_disturbed()));
  const auto refused = [](double SynthDisturbances::*field, double value, const std::string& sentence) {
    SynthOptions options = walk_options();
    options.disturbances.*field = value;
    CHECK_THROWS_WITH(check(options), sentence);
  };
  refused(&SynthDisturbances::pose_noise, -1,
          "synth: pose_noise is -1, must be at least 0 and at most an eighth of the width");
  refused(&SynthDisturbances::pose_noise, 6.5,
          "synth: pose_noise is 6.5, must be at least 0 and at most an eighth of the width");
  refused(&SynthDisturbances::exposure_noise, -0.5, "synth: exposure_noise is -0.5, must be in [0, 10]");
  refused(&SynthDisturbances::white_balance_noise, 11, "synth: white_balance_noise is 11, must be in [0, 10]");
  refused(&SynthDisturbances::wrong_poses, 1.5, "synth: wrong_poses is 1.5, must be in [0, 1]");
  refused(&SynthDisturbances::passers_by, std::nan(""), "synth: passers_by is nan, must be in [0, 1]");
  refused(&SynthDisturbances::vignetting, 1, "synth: vignetting is 1, must be in [0, 1)");
  refused(&SynthDisturbances::noise, 65, "synth: noise is 65, must be in [0, 64]");
  refused(&SynthDisturbances::blur, 7, "synth: blur is 7, must be at least 0 and at most an eighth of the width");
  refused(&SynthDisturbances::mesh_noise, -0.1, "synth: mesh_noise is -0.1, must be in [0, 1]");
  refused(&SynthDisturbances::holes, 1, "synth: holes is 1, must be in [0, 0.95]");
  refused(&SynthDisturbances::decimate, 0, "synth: decimate is 0, must be in [0.001, 1]");
}

}  // namespace
}  // namespace lumatlas
