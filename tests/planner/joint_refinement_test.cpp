// SPDX-License-Identifier: GPL-3.0-or-later
// All views of a relief at once: derivatives, wrong poses and gains, exact ones, threads; and bent pictures.
#include "planner/joint_refinement.h"

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "planner/displacement_estimate.h"
#include "tests/support/relief_scenes.h"

namespace lumatlas {
namespace {

constexpr std::uint32_t kViews = 8;

Camera true_camera(std::uint32_t number) {
  const double turn = 2.4 * number;
  return relief_camera({1.1 * std::cos(turn), 0.7 * std::sin(turn), 0.2 * std::sin(3 * turn)},
                       {0.5 * std::cos(turn + 1), 0.4 * std::sin(turn + 1), 4});
}

// What a picture shows whose lattice is `bend`: the true picture's p is found at p + bend(p).
Photograph bent(const Photograph& photograph, const Camera& camera, const Displacement& bend) {
  const Pyramid pyramid(photograph);
  Photograph result = photograph;
  for (std::uint32_t y = 0; y < photograph.height; ++y) {
    for (std::uint32_t x = 0; x < photograph.width; ++x) {
      const glm::dvec2 at(x + 0.5, y + 0.5);
      const glm::dvec3 color = pyramid.color(0, at - bend.at(camera, at));  // to first order the inverse
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const double srgb = 1.055 * std::pow(color[static_cast<int>(channel)], 1 / 2.4) - 0.055;
        result.rgb[3 * (std::size_t{y} * photograph.width + x) + channel] =
            static_cast<std::uint8_t>(std::lround(255 * std::min(std::max(srgb, 0.0), 1.0)));
      }
    }
  }
  return result;
}

// Views whose given poses are off by `px` and whose exposures by `stops`; the last one's picture may be bent.
struct WrongViews {
  WrongViews(double px, double stops, const Displacement& bend = {}) : gallery(kViews), samples(kViews) {
    for (std::uint32_t number = 0; number < kViews; ++number) {
      const Camera truth = true_camera(number);
      points.push_back(gallery.relief.points(truth, 16, 12));
      given.push_back(px > 0 ? disturbed(truth, px, number + 1, points.back()) : truth);
      Photograph photograph = gallery.relief.photograph(truth, glm::dvec3(std::exp2(stops * std::sin(5.0 * number))));
      if (number + 1 == kViews && !bend.empty()) photograph = bent(photograph, truth, bend);
      gallery.add(given.back(), photograph);
      const ComparedView& view = *gallery.views[number];
      samples[number] = choose_surface_samples(given.back(), view.pyramid,
                                               gallery.relief.visibility->trace(given.back().shrunk_to(160)), 800);
    }
  }

  [[nodiscard]] JointRefinement refine(const JointOptions& options = {}) const {
    return refine_jointly(gallery.atlas, gallery.views, given, samples, options);
  }

  // Mean error of the poses, pixels.
  [[nodiscard]] double error(const std::vector<Camera>& cameras) const {
    double sum = 0;
    for (std::uint32_t slot = 0; slot < kViews; ++slot) {
      sum += pose_error_px(cameras[slot], true_camera(slot), points[slot]);
    }
    return sum / kViews;
  }

  Gallery gallery;
  std::vector<Camera> given;
  std::vector<std::vector<glm::dvec3>> points;
  std::vector<std::vector<SurfaceSample>> samples;
};

// What the call says against its input, or "accepted".
template <typename Call>
std::string complaint(const Call& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST_CASE("brightness changes with a pose as finite differences say") {
  const WrongViews scene(3, 0.2);
  const ComparedView& view = *scene.gallery.views[2];
  const PoseFrame frame{scene.given[2], 4};
  const PoseOffset offset{0.02, -0.015, 0.03, 0.01, -0.02, 0.015};
  constexpr double kStep = 1e-7;  // far less than a pixel: bilinear interpolation has a bend at each pixel's middle
  std::size_t compared = 0;
  for (const glm::dvec3& point : scene.points[2]) {
    const auto value = [&](const PoseOffset& at) {
      return brightness_at(view, frame, at, camera_at(frame, at), 1, point);
    };
    const Brightness here = value(offset);
    if (!here.inside) continue;
    CAPTURE(here.image.x, here.image.y);
    for (std::size_t i = 0; i < offset.size(); ++i) {
      PoseOffset before = offset, after = offset;
      before[i] -= kStep;
      after[i] += kStep;
      CHECK(here.by_pose[i] == Approx((value(after).value - value(before).value) / (2 * kStep)).margin(2e-5));
    }
    ++compared;
  }
  CHECK(compared > 100);
}

TEST_CASE("an offset is found again from the camera that it makes") {
  const PoseFrame frame{true_camera(1), 4};
  const PoseOffset offset{0.2, -0.15, 0.3, 0.1, -0.2, 0.15};
  const PoseOffset found = offset_of(frame, camera_at(frame, offset));
  for (std::size_t i = 0; i < offset.size(); ++i) CHECK(found[i] == Approx(offset[i]).margin(1e-12));
}

TEST_CASE("outliers do not move a robust mean") {
  std::vector<double> values{0.51, 0.49, 0.5, 0.9, 0.5};
  CHECK(robust_mean(values, 0.02) == Approx(0.5).margin(1e-6));
  std::vector<double> alone{0.3};
  CHECK(robust_mean(alone, 0.01) == 0.3);
}

TEST_CASE("wrong poses and gains are made right together, judged by points that were not fitted to") {
  const WrongViews scene(3, 0.2);
  const JointRefinement found = scene.refine();
  CAPTURE(found.iterations, found.residual_before, found.residual_after);
  CHECK(found.views == kViews);
  CHECK(found.points > kViews * 100);
  CHECK(found.sights > 2 * found.points);
  CHECK(found.residual_after < 0.4 * found.residual_before);
  // What is left is what the set as a whole is off by: the mean of eight errors, about 3 px / sqrt(8).
  CHECK(scene.error(found.cameras) < 0.5 * 3);
  double worst = 0;
  const double scale = found.gain[0] * std::exp2(0.2 * std::sin(0.0));
  for (std::uint32_t slot = 0; slot < kViews; ++slot) {
    worst = std::max(worst, std::abs(found.gain[slot] * std::exp2(0.2 * std::sin(5.0 * slot)) / scale - 1));
  }
  CHECK(worst < 0.03);
}

TEST_CASE("exact poses stay as they are, to the bit") {
  const WrongViews scene(0, 0);
  const JointRefinement found = scene.refine();
  CAPTURE(found.residual_before, found.residual_after);
  CHECK(found.residual_before > 0);
  CHECK(found.residual_after == found.residual_before);
  for (std::uint32_t slot = 0; slot < kViews; ++slot) {
    CHECK(found.cameras[slot].cam_from_world_translation == scene.given[slot].cam_from_world_translation);
    CHECK(found.cameras[slot].cam_from_world_rotation == scene.given[slot].cam_from_world_rotation);
    CHECK(found.gain[slot] == 1);
  }
}

TEST_CASE("joint refinement moves poses only, or gains only, if it is told to") {
  const WrongViews scene(2, 0.2);
  JointOptions options;
  options.alignment.pose = false;
  const JointRefinement gains = scene.refine(options);
  for (std::uint32_t slot = 0; slot < kViews; ++slot) {
    CHECK(gains.cameras[slot].cam_from_world_translation == scene.given[slot].cam_from_world_translation);
  }
  CHECK(gains.residual_after < gains.residual_before);
  options.alignment.pose = true;
  options.alignment.exposure = false;
  const JointRefinement poses = scene.refine(options);
  for (std::uint32_t slot = 0; slot < kViews; ++slot) CHECK(poses.gain[slot] == 1);
}

TEST_CASE("joint refinement and displacements are the same on any number of threads") {
  const WrongViews scene(2, 0.1);
  const auto on = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return std::pair(scene.refine(),
                     estimate_displacements(scene.gallery.atlas, scene.gallery.views, scene.samples, {}));
  };
  const auto one = on(1), many = on(8);
  CHECK(one.first.residual_after == many.first.residual_after);
  CHECK(one.first.gain == many.first.gain);
  for (std::uint32_t slot = 0; slot < kViews; ++slot) {
    CHECK(one.first.cameras[slot].cam_from_world_translation == many.first.cameras[slot].cam_from_world_translation);
    CHECK(one.first.cameras[slot].cam_from_world_rotation == many.first.cameras[slot].cam_from_world_rotation);
  }
  CHECK(one.second.of_slot == many.second.of_slot);
}

TEST_CASE("joint refinement can be stopped, and refuses what does not fit") {
  struct Stop {};
  const WrongViews scene(1, 0);
  JointOptions options;
  int calls = 40;
  options.interruption_point = [&] {
    if (--calls < 0) throw Stop();
  };
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  CHECK_THROWS_AS(scene.refine(options), Stop);
  options = {};
  options.most_points = 0;
  CHECK(complaint([&] { (void)scene.refine(options); }) == "joint refinement: most_points is 0, must be at least 1");
  CHECK(complaint([&] { (void)refine_jointly(scene.gallery.atlas, scene.gallery.views, {}, scene.samples, {}); }) ==
        "joint refinement: the size of given is 0, must be the atlas's capacity, 8");
  DisplacementOptions lattices;
  lattices.columns = 1;
  CHECK(complaint([&] {
          (void)estimate_displacements(scene.gallery.atlas, scene.gallery.views, scene.samples, lattices);
        }) == "displacements: columns is 1, must be at least 2");
}

TEST_CASE("a picture that no pose explains is bent until it agrees with the others") {
  Displacement bend{13, 10, {}};
  for (int row = 0; row < 10; ++row) {
    for (int column = 0; column < 13; ++column) {
      bend.nodes.emplace_back(1.2 * std::sin(0.7 * row), 1.2 * std::cos(0.5 * column));
    }
  }
  const WrongViews scene(0, 0, bend);
  DisplacementOptions options;
  options.neighbour_deviation = 2;  // the relief's colours change slowly, and are without noise
  options.deviation = 8;
  const DisplacementEstimates found =
      estimate_displacements(scene.gallery.atlas, scene.gallery.views, scene.samples, options);
  CAPTURE(found.views, found.displaced, found.mean_px, found.residual_before, found.residual_after);
  CHECK(found.views == kViews);
  CHECK(found.residual_after < 0.9 * found.residual_before);
  const Displacement& lattice = found.of_slot[kViews - 1];
  REQUIRE_FALSE(lattice.empty());
  double before = 0, after = 0;
  for (const glm::dvec3& point : scene.points[kViews - 1]) {
    const Camera& camera = scene.given[kViews - 1];
    const glm::dvec2 image = camera.image_from_cam(camera.cam_from_world(point));
    before += glm::length(bend.at(camera, image));
    after += glm::distance(bend.at(camera, image), lattice.at(camera, image));
  }
  CAPTURE(before, after);
  CHECK(after < 0.5 * before);
}

}  // namespace
}  // namespace lumatlas
