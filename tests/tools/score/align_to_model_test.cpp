// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/align_to_model.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>

#include "planner/refinement/photometry.h"
#include "tests/support/scenes/relief_scenes.h"
#include "tools/score/measures/scores.h"

namespace lumatlas {
namespace {

// A relief whose pictures are drawn at the camera's true place less a share of how far it is from `truth`, as where
// views change with the pose: a search from one picture then ends short of the truth, or beyond it.
struct SlidingModel {
  explicit SlidingModel(double share) : share_(share) {}

  [[nodiscard]] Photograph picture(const Camera& camera) const {
    const auto [turn, shift] = motion_between(truth, camera);
    const Camera shown = moved(camera, -share_ * turn, -share_ * shift);
    return relief.photograph(shown);
  }
  [[nodiscard]] ModelPictures pictures() {
    return {[this](const Camera& camera) { return ++drawn, picture(camera); },
            [this](const Camera& camera) { return ++sketched, picture(camera); }, *relief.visibility};
  }

  Relief relief;
  Camera truth = relief_camera({0.5, -0.3, 0}, {0.2, 0.1, 4});
  Photograph photograph = relief.photograph(truth);
  Pyramid pyramid{photograph};
  std::vector<glm::dvec3> points = relief.points(truth, 40, 30);
  int drawn = 0, sketched = 0;

 private:
  double share_;
};

// How far a pose that is wrong by `wrong_px` pixels is from the truth once it is aligned. The alignment must have drawn
// `sketches` sketches of the model.
double error_after_px(SlidingModel& model, double wrong_px, int sketches) {
  const Camera given = disturbed(model.truth, wrong_px, 1, model.points);
  const Seen at_given{model.picture(given), model.relief.visibility->trace(given)};
  const auto aligned = align_to_model(model.pictures(), given, at_given, model.pyramid);
  REQUIRE(aligned);
  CHECK(model.drawn == 1);
  CHECK(model.sketched == sketches);
  CHECK(aligned->seen.picture.rgb == model.picture(aligned->camera).rgb);
  CHECK(aligned->seen.visible.face == model.relief.visibility->trace(aligned->camera).face);
  return pose_error_px(aligned->camera, model.truth, model.points);
}

TEST_CASE("a held-out pose comes back to a tenth of a pixel, with one picture, where pictures do not change with it") {
  for (const double wrong_px : {0.5, 1.0, 3.0}) {
    CAPTURE(wrong_px);
    SlidingModel model(0);
    CHECK(error_after_px(model, wrong_px, 0) < 0.1);
  }
}

TEST_CASE("a pose that is near comes back, except for the share by which pictures change with it") {
  for (const double share : {0.3, -0.3}) {
    CAPTURE(share);
    SlidingModel model(share);
    CHECK(error_after_px(model, 3, 0) < 3 * std::abs(share) + 0.1);
  }
}

TEST_CASE("a pose that is far away comes back to a fifth of a pixel, with a sketch, whether pictures change or not") {
  for (const double share : {0.0, 0.3, -0.3}) {
    CAPTURE(share);
    SlidingModel model(share);
    const double wrong_px = 8;
    REQUIRE((1 - std::abs(share)) * wrong_px > kFarAlignment * model.truth.width);
    CHECK(error_after_px(model, wrong_px, 1) < 0.2);
  }
}

TEST_CASE("a photograph whose given pose is wrong gets back what it scores where it was taken") {
  SlidingModel model(0);
  const std::vector<std::uint8_t> all;
  const Camera given = disturbed(model.truth, 3, 2, model.points);
  const Seen at_given{model.picture(given), model.relief.visibility->trace(given)};
  const auto aligned = align_to_model(model.pictures(), given, at_given, model.pyramid);
  REQUIRE(aligned);
  CHECK(psnr(at_given.picture, model.photograph, all) < 35);
  // The only difference there is that of a tenth of a pixel in waves that are 14 pixels long: about a level.
  CHECK(psnr(aligned->seen.picture, model.photograph, all) > 45);
}

TEST_CASE("a pose that is right stays, and nothing is drawn") {
  SlidingModel model(0);
  const Seen at_given{model.photograph, model.relief.visibility->trace(model.truth)};
  CHECK_FALSE(align_to_model(model.pictures(), model.truth, at_given, model.pyramid));
  CHECK(model.drawn == 0);
  CHECK(model.sketched == 0);
}

}  // namespace
}  // namespace lumatlas
