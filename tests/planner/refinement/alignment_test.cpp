// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/alignment.h"

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <random>
#include <utility>

#include "planner/refinement/photometry.h"
#include "tests/support/refusal.h"
#include "tests/support/scenes/relief_scenes.h"

namespace lumatlas {
namespace {

// Hardly any pull towards the given pose: the colours alone decide.
AlignmentOptions almost_free() {
  AlignmentOptions options;
  options.prior = 0.02;
  return options;
}

// A photograph taken at a known pose and exposure, and points of the relief with their true colours.
struct Shot {
  explicit Shot(const glm::dvec3& exposure = glm::dvec3(1.0), const Placement& placement = {})
      : relief(placement),
        truth(relief_camera({0.5, -0.3, 0}, {0.2, 0.1, 4}, placement)),
        photograph(relief.photograph(truth, exposure)),
        pyramid(photograph),
        points(relief.points(truth, 40, 30)) {
    targets.positions = points;
    targets.colors.resize(pyramid.levels());
    for (const glm::dvec3& point : points) {
      for (auto& colors : targets.colors) colors.emplace_back(relief_color(placement.relief(point)));
    }
  }
  [[nodiscard]] Alignment align_from(const Camera& given, const AlignmentOptions& options = almost_free()) const {
    return align(given, given, glm::dvec3(1.0), pyramid, targets, options);
  }
  [[nodiscard]] Camera off_by(double px, std::uint32_t seed) const { return disturbed(truth, px, seed, points); }
  [[nodiscard]] double error_px(const Camera& camera) const { return pose_error_px(camera, truth, points); }

  Relief relief;
  Camera truth;
  Photograph photograph;
  Pyramid pyramid;
  std::vector<glm::dvec3> points;
  AlignmentTargets targets;
};

AlignmentOptions pose_alone() {
  AlignmentOptions options = almost_free();
  options.exposure = false;
  return options;
}

// Wrong colours, none near the right one, for a share of the points.
void spoil(AlignmentTargets& targets, double share) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (std::size_t point = 0; point < targets.positions.size(); ++point) {
    if (uniform(random) >= share) continue;
    const glm::vec3 wrong(0.5 + 0.4 * uniform(random), 0.4 * uniform(random), 0.5 * uniform(random));
    for (auto& colors : targets.colors) colors[point] = wrong;
  }
}

TEST_CASE("the motion between two cameras moves the one to the other") {
  const Camera from = moved({}, {0.3, -0.2, 0.1}, {1, 2, 3});
  const Camera to = moved(from, {-0.01, 0.02, 0.5}, {0.1, -0.2, 0.3});
  const auto [turn, shift] = motion_between(from, to);
  const Camera back = moved(from, turn, shift);
  CHECK(glm::distance(turn, glm::dvec3(-0.01, 0.02, 0.5)) < 1e-12);
  CHECK(glm::distance(back.cam_from_world_translation, to.cam_from_world_translation) < 1e-12);
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(glm::distance(back.cam_from_world_rotation[axis], to.cam_from_world_rotation[axis]) < 1e-12);
  }
  CHECK(motion_between(from, from).turn == glm::dvec3(0));
}

TEST_CASE("a disturbed pose comes back to a tenth of a pixel") {
  const Shot shot;
  for (const double px : {0.5, 2.0, 8.0}) {
    for (const std::uint32_t seed : {1u, 2u, 3u}) {
      CAPTURE(px, seed);
      const Camera given = shot.off_by(px, seed);
      REQUIRE(shot.error_px(given) == Approx(px));
      const Alignment result = shot.align_from(given);
      CHECK(result.moved);
      CHECK(shot.error_px(result.camera) < 0.1);
      CHECK(result.moved_px == Approx(px).epsilon(0.7));  // a median beside a root of the mean square
      CHECK(result.residual < result.residual_exposed);
      CHECK(result.residual_exposed <= result.residual_given);
      CHECK(result.residual < 0.01);
      CHECK(result.correlation.value() > 0.95);
      CHECK(result.gain.r == Approx(1).epsilon(0.01));
    }
  }
}

// The black that undistortion leaves along the border, and that of a mask: blobs all over the picture.
void blacken(Photograph& photograph) {
  photograph.valid.assign(std::size_t{photograph.width} * photograph.height, 255);
  for (std::uint32_t y = 0; y < photograph.height; ++y) {
    for (std::uint32_t x = 0; x < photograph.width; ++x) {
      const glm::dvec2 off = (glm::dvec2(x, y) + 0.5) / glm::dvec2(photograph.width, photograph.height) - 0.5;
      const bool in_border =
          std::abs(off.x) > 0.46 - 0.12 * off.y * off.y || std::abs(off.y) > 0.46 - 0.12 * off.x * off.x;
      const glm::ivec2 from_blob(static_cast<int>(x % 40) - 20, static_cast<int>(y % 36) - 18);
      const bool in_blob = from_blob.x * from_blob.x + from_blob.y * from_blob.y < 64;
      if (!in_border && !in_blob) continue;
      const std::size_t pixel = std::size_t{y} * photograph.width + x;
      photograph.valid[pixel] = 0;
      for (std::size_t channel = 0; channel < 3; ++channel) photograph.rgb[3 * pixel + channel] = 0;
    }
  }
}

// A shot that is black in places, with the points that it shows at its true pose.
struct BlackenedShot : Shot {
  BlackenedShot() {
    blacken(photograph);
    pyramid = Pyramid(photograph);
    AlignmentTargets shown;
    shown.colors.resize(pyramid.levels());
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!pyramid.is_valid(truth.image_from_cam(truth.cam_from_world(points[i])))) continue;
      shown.positions.push_back(points[i]);
      for (std::size_t level = 0; level < shown.colors.size(); ++level) {
        shown.colors[level].push_back(targets.colors[level][i]);
      }
    }
    REQUIRE(shown.positions.size() > 500);
    REQUIRE(shown.positions.size() < points.size());
    targets = std::move(shown);
  }
};

TEST_CASE("the black outside of the lens's image and under a mask does not move the pose") {
  const BlackenedShot shot;
  for (const double px : {0.5, 2.0, 8.0}) {
    for (const std::uint32_t seed : {1u, 2u, 3u}) {
      CAPTURE(px, seed);
      const Alignment result = shot.align_from(shot.off_by(px, seed));
      CHECK(result.moved);
      CHECK(shot.error_px(result.camera) < 0.1);
      CHECK(result.gain.r == Approx(1).epsilon(0.01));
    }
  }
}

TEST_CASE("a search from far away is not led astray by the black under a mask") {
  const BlackenedShot shot;
  AlignmentOptions options = almost_free();
  options.max_move = 0.5;
  int found = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    found += shot.error_px(shot.align_from(shot.off_by(16, seed), options).camera) < 0.1;
  }
  CHECK(found >= 10);
}

TEST_CASE("an exposure of two stops either way comes back within one percent, the pose being right") {
  for (const double exposure : {0.25, 0.7, 1.0, 4.0}) {
    CAPTURE(exposure);
    const Shot shot{glm::dvec3(exposure)};
    AlignmentOptions options = almost_free();
    options.pose = false;
    const Alignment result = shot.align_from(shot.truth, options);
    CHECK(result.gain.r == Approx(1 / exposure).epsilon(0.01));
    CHECK(result.gain.r == result.gain.g);
    CHECK(result.gain.r == result.gain.b);
    CHECK(result.residual == result.residual_exposed);
    CHECK(result.correlation.value() > 0.95);
  }
}

TEST_CASE("white balance comes back channel by channel, and one gain for all is between the channels'") {
  const glm::dvec3 exposure(1.5, 1.0, 0.6);
  const Shot shot(exposure);
  AlignmentOptions options = almost_free();
  options.white_balance = true;
  const Alignment balanced = shot.align_from(shot.truth, options);
  for (int channel = 0; channel < 3; ++channel) {
    CHECK(balanced.gain[channel] == Approx(1 / exposure[channel]).epsilon(0.01));
  }
  const Alignment grey = shot.align_from(shot.truth);
  CHECK(grey.gain.r == grey.gain.b);
  CHECK(grey.gain.r > 1 / 1.5);
  CHECK(grey.gain.r < 1 / 0.6);
  CHECK(grey.residual > 2 * balanced.residual);
}

TEST_CASE("pose, exposure and white balance come back together") {
  const glm::dvec3 exposure(0.30, 0.25, 0.20);
  const Shot shot(exposure);
  AlignmentOptions options = almost_free();
  options.white_balance = true;
  for (const std::uint32_t seed : {4u, 5u}) {
    const Alignment result = shot.align_from(shot.off_by(4, seed), options);
    CHECK(result.moved);
    CHECK(shot.error_px(result.camera) < 0.15);  // dark pixels are coarser
    for (int channel = 0; channel < 3; ++channel) {
      CHECK(result.gain[channel] == Approx(1 / exposure[channel]).epsilon(0.01));
    }
  }
}

TEST_CASE("thirty percent of wrong colours do not keep pose and exposure from coming back") {
  Shot shot{glm::dvec3(0.5)};
  spoil(shot.targets, 0.3);
  for (const std::uint32_t seed : {6u, 7u}) {
    const Alignment result = shot.align_from(shot.off_by(3, seed));
    CHECK(result.moved);
    CHECK(shot.error_px(result.camera) < 0.15);
    CHECK(result.gain.r == Approx(2).epsilon(0.01));
  }
}

TEST_CASE("with the pose switched off the camera stays to the last bit and the exposure is still found") {
  const Shot shot{glm::dvec3(0.5)};
  AlignmentOptions options = almost_free();
  options.pose = false;
  const Camera given = shot.off_by(2, 8);
  const Alignment result = shot.align_from(given, options);
  CHECK_FALSE(result.moved);
  CHECK(result.moved_px == 0);
  CHECK(same_pose(result.camera, given));
  CHECK(result.gain.r == Approx(2).epsilon(0.1));
}

TEST_CASE("with the exposure switched off the gain stays what it was given") {
  const Shot shot{glm::dvec3(0.5)};
  const Camera given = shot.off_by(2, 8);
  const Alignment result = align(given, given, glm::dvec3(2.0), shot.pyramid, shot.targets, pose_alone());
  CHECK(result.gain == glm::dvec3(2.0));
  CHECK(result.moved);
  CHECK(shot.error_px(result.camera) < 0.1);
}

TEST_CASE("with everything switched off nothing changes and the residual is reported") {
  const Shot shot;
  AlignmentOptions options = pose_alone();
  options.pose = false;
  const Camera given = shot.off_by(3, 8);
  const Alignment result = shot.align_from(given, options);
  CHECK(same_pose(result.camera, given));
  CHECK(result.gain == glm::dvec3(1.0));
  CHECK(result.residual > 0);
  CHECK(result.residual == result.residual_given);
}

TEST_CASE("a move beyond the bound is not taken, and one within it is") {
  const Shot shot;
  const Camera given = shot.off_by(6, 9);
  AlignmentOptions options = almost_free();
  options.max_move = 3.0 / shot.truth.width;
  const Alignment bounded = shot.align_from(given, options);
  CHECK_FALSE(bounded.moved);
  CHECK(same_pose(bounded.camera, given));
  CHECK(bounded.moved_px == 0);
  CHECK(bounded.residual == bounded.residual_exposed);
  options.max_move = 12.0 / shot.truth.width;
  CHECK(shot.align_from(given, options).moved);
}

TEST_CASE("the stronger the pull, the nearer the pose stays to the given one") {
  const Shot shot;
  const Camera given = shot.off_by(4, 9);
  double last = std::numeric_limits<double>::infinity();
  for (const double prior : {0.02, 40.0, 4000.0}) {
    AlignmentOptions options;
    options.prior = prior;
    options.least_improvement = 0;
    const double moved = shot.align_from(given, options).moved_px;
    CHECK(moved < last);
    last = moved;
  }
}

TEST_CASE("the bound is around the given pose, wherever the search starts") {
  const Shot shot;
  const Camera given = shot.off_by(6, 9);
  AlignmentOptions options = almost_free();
  options.max_move = 3.0 / shot.truth.width;
  const Alignment result = align(given, shot.truth, glm::dvec3(1.0), shot.pyramid, shot.targets, options);
  CHECK_FALSE(result.corrected);
  CHECK(result.moved);  // from where it started, back to the given pose
  CHECK(same_pose(result.camera, given));
}

TEST_CASE("a start that is nearer than the given pose is used") {
  const Shot shot;
  const Camera given = shot.off_by(8, 10);
  AlignmentOptions options = almost_free();
  options.levels = 1;
  options.max_iterations = 3;
  const Alignment result = align(given, shot.off_by(0.3, 3), glm::dvec3(1.0), shot.pyramid, shot.targets, options);
  CHECK(result.moved);
  CHECK(shot.error_px(result.camera) < 0.1);
}

TEST_CASE("one iteration is one step") {
  const Shot shot;
  const Camera given = shot.off_by(1, 10);
  AlignmentOptions options = almost_free();
  options.levels = 1;
  options.max_iterations = 1;
  const Alignment result = shot.align_from(given, options);
  CHECK(result.moved);
  CHECK(shot.error_px(result.camera) < 0.5 * shot.error_px(given));
}

TEST_CASE("a search that starts at its end stays there to the last bit, though the given pose is another") {
  const Shot shot;
  const Camera given = shot.off_by(4, 10);
  const Alignment first = shot.align_from(given);
  REQUIRE(first.corrected);
  REQUIRE(first.moved);
  const Alignment again = align(given, first.camera, first.gain, shot.pyramid, shot.targets, almost_free());
  CHECK(again.corrected);
  CHECK_FALSE(again.moved);
  CHECK(same_pose(again.camera, first.camera));
  CHECK(again.moved_px == first.moved_px);
  CHECK(again.residual == again.residual_start);
  CHECK(again.residual_exposed > again.residual_start);
  // From further away than noise, it is moved again.
  CHECK(align(given, shot.off_by(1, 3), first.gain, shot.pyramid, shot.targets, almost_free()).moved);
}

TEST_CASE("what an alignment is given must fit together") {
  const Shot shot;
  const auto complaint = [&](const auto& change) -> std::string {
    Camera given = shot.truth, start = shot.truth;
    glm::dvec3 gain(1.0);
    AlignmentTargets targets = shot.targets;
    change(given, start, gain, targets);
    try {
      (void)align(given, start, gain, shot.pyramid, targets, almost_free());
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  using Targets = AlignmentTargets;
  CHECK(complaint([](Camera&, Camera&, glm::dvec3&, Targets&) {}) == "accepted");
  CHECK(complaint([](Camera& given, Camera&, glm::dvec3&, Targets&) { given.width = 100; }) ==
        "alignment: given.width is 100, must be the photograph's");
  CHECK(complaint([](Camera&, Camera& start, glm::dvec3&, Targets&) { start.height = 100; }) ==
        "alignment: start.height is 100, must be given.height");
  CHECK(complaint([](Camera&, Camera& start, glm::dvec3&, Targets&) { start.fx = 100; }) ==
        "alignment: start.fx is 100, must be given.fx");
  CHECK(complaint([](Camera&, Camera& start, glm::dvec3&, Targets&) { start.fy = -1; }).find("fy") !=
        std::string::npos);
  CHECK(complaint([](Camera&, Camera&, glm::dvec3& gain, Targets&) { gain.g = 0; }) ==
        "alignment: gain is 0, must be finite and positive");
  CHECK(complaint([](Camera&, Camera&, glm::dvec3&, Targets& targets) { targets.colors.pop_back(); }) ==
        "alignment: the size of targets.colors is 1, must be the number of the pyramid's levels, 2");
  CHECK(complaint([](Camera&, Camera&, glm::dvec3&, Targets& targets) { targets.colors[1].pop_back(); }) ==
        "alignment: the size of a level of targets.colors is 1199, must be the number of the positions, 1200");
}

TEST_CASE("a pose that is right already stays to the last bit") {
  const Shot shot;
  const Alignment result = shot.align_from(shot.truth);
  CHECK_FALSE(result.moved);
  CHECK(same_pose(result.camera, shot.truth));
  CHECK(result.moved_px == 0);
}

TEST_CASE("too few points change nothing") {
  Shot shot{glm::dvec3(0.5)};
  const std::size_t few = kFewestAlignmentPoints - 1;
  shot.targets.positions.resize(few);
  for (auto& colors : shot.targets.colors) colors.resize(few);
  const Camera given = shot.off_by(2, 12);
  Alignment result = shot.align_from(given);
  CHECK_FALSE(result.moved);
  CHECK(same_pose(result.camera, given));
  CHECK(result.gain == glm::dvec3(1.0));
  shot.targets = {};
  shot.targets.colors.resize(shot.pyramid.levels());
  result = shot.align_from(given);
  CHECK(same_pose(result.camera, given));
}

TEST_CASE("points behind the camera and beside the picture are survived") {
  Shot shot;
  for (std::size_t i = 0; i < 100; ++i) {
    shot.targets.positions.push_back({0.01 * static_cast<double>(i), i % 2 ? 40 : 0, i % 2 ? 4 : -3});
    for (auto& colors : shot.targets.colors) colors.emplace_back(0.1f);
  }
  const Alignment result = shot.align_from(shot.off_by(2, 13));
  CHECK(result.moved);
  CHECK(shot.error_px(result.camera) < 0.1);
}

TEST_CASE("a photograph of one flat colour moves no pose") {
  Shot shot;
  std::fill(shot.photograph.rgb.begin(), shot.photograph.rgb.end(), std::uint8_t{90});
  const Pyramid flat(shot.photograph);
  const Alignment result = align(shot.truth, shot.truth, glm::dvec3(1.0), flat, shot.targets, AlignmentOptions{});
  CHECK_FALSE(result.moved);
  CHECK(std::abs(result.correlation.value()) < 0.3);
}

TEST_CASE("levels that are not needed change nothing, to the bit, and may be empty; needed ones are refused") {
  Shot shot(glm::dvec3(1.3));
  const Camera given = shot.off_by(1, 1);
  AlignmentOptions options = almost_free();
  options.levels = 1;
  REQUIRE(shot.pyramid.levels() >= 2);
  const std::uint32_t coarsest = shot.pyramid.levels() - 1;
  const Alignment asked = shot.align_from(given, options);
  CHECK(asked.correlation);
  options.correlation = false;
  CHECK(needs_level(options, shot.pyramid, 0));
  CHECK(needs_level(options, shot.pyramid, coarsest));  // where the exposure starts
  Alignment result = shot.align_from(given, options);
  CHECK_FALSE(result.correlation);
  CHECK(same_pose(result.camera, asked.camera));
  CHECK(result.gain == asked.gain);
  CHECK(result.residual == asked.residual);

  options.exposure = false;
  const Alignment all_levels = shot.align_from(given, options);
  for (std::uint32_t level = 1; level <= coarsest; ++level) {
    CHECK_FALSE(needs_level(options, shot.pyramid, level));
    shot.targets.colors[level].clear();
  }
  result = shot.align_from(given, options);
  CHECK(same_pose(result.camera, all_levels.camera));
  CHECK(result.residual == all_levels.residual);
  options.exposure = true;
  CHECK_THROWS_WITH((void)shot.align_from(given, options),
                    "alignment: the size of a level of targets.colors is 0, must be the number of the positions, 1200");
}

TEST_CASE("where photograph and surface are both plain there is no correlation, not a low one") {
  Shot shot;
  std::fill(shot.photograph.rgb.begin(), shot.photograph.rgb.end(), std::uint8_t{90});
  for (auto& colors : shot.targets.colors) std::fill(colors.begin(), colors.end(), glm::vec3(0.1f));
  const Alignment result =
      align(shot.truth, shot.truth, glm::dvec3(1.0), Pyramid(shot.photograph), shot.targets, AlignmentOptions{});
  CHECK_FALSE(result.correlation);
  CHECK_FALSE(result.moved);
}

TEST_CASE("the photograph of another place has a low correlation") {
  const Shot shot;
  const Photograph elsewhere = shot.relief.photograph(relief_camera({1.7, 1.2, 0.5}, {1.9, 1.1, 4}));
  const Pyramid other(elsewhere);
  const Alignment result = align(shot.truth, shot.truth, glm::dvec3(1.0), other, shot.targets, AlignmentOptions{});
  CHECK(result.correlation.value() < 0.5);
}

TEST_CASE("the result does not depend on the scene's scale, nor on where in the world it is") {
  const Camera reference = [] {
    const Shot shot;
    return shot.align_from(shot.off_by(3, 14)).camera;
  }();
  const glm::dmat3 turn(glm::rotate(glm::dmat4(1), 1.1, glm::normalize(glm::dvec3(0.3, -1, 0.5))));
  const Placement placements[] = {{1e-3, glm::dmat3(1), glm::dvec3(0)},
                                  {1e4, glm::dmat3(1), glm::dvec3(0)},
                                  {1, turn, {3, -2, 5}},
                                  {25, turn, {10, 20, -30}}};
  for (const Placement& placement : placements) {
    CAPTURE(placement.scale);
    const Shot shot(glm::dvec3(1.0), placement);
    const Alignment result = shot.align_from(shot.off_by(3, 14));
    CHECK(result.moved);
    CHECK(shot.error_px(result.camera) < 0.1);
    Camera expected = reference;
    expected.cam_from_world_rotation = reference.cam_from_world_rotation * glm::transpose(placement.rotation);
    expected.cam_from_world_translation = placement.scale * reference.cam_from_world_translation -
                                          expected.cam_from_world_rotation * placement.translation;
    // The mesh has float positions, so a few pixels of the photograph round otherwise.
    CHECK(pose_error_px(result.camera, expected, shot.points) < 0.01);
  }
}

TEST_CASE("a camera that is aligned a thousand times over still has a rotation") {
  const Shot shot;
  const Camera there = shot.off_by(1, 15);
  const Photograph other = shot.relief.photograph(there);
  const Pyramid pyramids[] = {Pyramid(shot.photograph, 200), Pyramid(other, 200)};
  AlignmentTargets few;
  few.colors.resize(1);
  for (std::size_t i = 0; i < shot.points.size(); i += 10) {
    few.positions.push_back(shot.points[i]);
    few.colors[0].push_back(shot.targets.colors[0][i]);
  }
  Camera camera = shot.truth;
  std::size_t moves = 0;
  for (std::size_t repeat = 0; repeat < 1000; ++repeat) {
    const Alignment result = align(camera, camera, glm::dvec3(1.0), pyramids[(repeat + 1) % 2], few, pose_alone());
    moves += result.moved;
    camera = result.camera;
  }
  CHECK(moves > 900);
  CHECK_NOTHROW(check(camera));
  CHECK(shot.error_px(camera) < 0.2);
}

TEST_CASE("an alignment has the same bits on one thread as on four") {
  const Shot shot{glm::dvec3(0.6)};
  const Camera given = shot.off_by(3, 16);
  const auto aligned = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return shot.align_from(given);
  };
  const Alignment one = aligned(1), four = aligned(4);
  CHECK(same_pose(one.camera, four.camera));
  CHECK(one.gain == four.gain);
  CHECK(one.residual == four.residual);
  CHECK(one.correlation.value() == four.correlation.value());
}

TEST_CASE("alignment options that break a rule are refused by name") {
  const auto refusal_of = [](const auto& change) { return refusal<AlignmentOptions>(change); };
  CHECK(refusal_of([](AlignmentOptions& o) { o.max_move = 0; }) ==
        "alignment: max_move is 0, must be finite and positive");
  CHECK(refusal_of([](AlignmentOptions& o) { o.prior = -1; }) ==
        "alignment: prior is -1, must be finite and not negative");
  CHECK(refusal_of([](AlignmentOptions& o) { o.least_improvement = 1; }) ==
        "alignment: least_improvement is 1, must be in [0, 1)");
  CHECK(refusal_of([](AlignmentOptions& o) { o.least_move_px = -1; }) ==
        "alignment: least_move_px is -1, must be finite and not negative");
  CHECK(refusal_of([](AlignmentOptions& o) { o.levels = 0; }) == "alignment: levels is 0, must be at least 1");
  CHECK(refusal_of([](AlignmentOptions& o) { o.max_iterations = 0; }) ==
        "alignment: max_iterations is 0, must be at least 1");
  CHECK(refusal_of([](AlignmentOptions&) {}) == "accepted");
}

}  // namespace
}  // namespace lumatlas
