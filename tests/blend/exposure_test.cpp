// SPDX-License-Identifier: GPL-3.0-or-later
// The laws of a picture's exposure, on stored views of which only pose, depth and gain matter.
#include "blend/exposure.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <random>

#include "tests/support/scenes/view_parts.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

struct PosedGain {
  Camera camera;
  glm::dvec3 gain{1.0};
};

// Looks from `center` in the direction that lies `turn` radians from +z towards +x.
Camera turned_camera(const glm::dvec3& center, double turn) {
  Camera camera = forward_camera(8, 6);
  const glm::dmat4 cam_from_world = glm::rotate(glm::dmat4(1), turn, glm::dvec3(0, -1, 0));
  camera.cam_from_world_rotation = glm::dmat3(cam_from_world);
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
  return camera;
}

// Stored views that see a surface at depth `D` on all of their pixels.
Snapshot snapshot_of(const std::vector<PosedGain>& views, float D) {
  Snapshot snapshot;
  for (const PosedGain& view : views) {
    StoredView stored;
    stored.camera = view.camera;
    own_mask(stored).depth.values().assign(std::size_t{view.camera.width} * view.camera.height, D);
    snapshot.views.push_back(std::make_shared<const StoredView>(std::move(stored)));
    snapshot.gains.push_back(view.gain);
  }
  return snapshot;
}

// Two stops apart, at places 20 apart.
std::vector<PosedGain> far_apart() {
  return {{turned_camera({0, 0, 0}, 0), glm::dvec3(0.5)}, {turned_camera({20, 0, 0}, 0), glm::dvec3(2)}};
}

// All over a room of 4 x 4 x 4, their gains between 1/4 and 4 in each channel.
std::vector<PosedGain> scattered(std::size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> at(0, 4), turn(-3, 3), stops(-2, 2);
  std::vector<PosedGain> views;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = at(random), y = at(random), z = at(random), angle = turn(random);
    const double red = stops(random), green = stops(random), blue = stops(random);
    views.push_back({turned_camera({x, y, z}, angle), glm::exp2(glm::dvec3(red, green, blue))});
  }
  return views;
}

double largest_difference(const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 difference = glm::abs(a - b);
  return std::max({difference.x, difference.y, difference.z});
}

TEST_CASE("without a stored view, and with gains of 1, the exposure is exactly 1") {
  const Camera camera = forward_camera(8, 6, {1, 2, 3});
  CHECK(NearbyExposure().at(camera) == glm::dvec3(1));
  CHECK(NearbyExposure(Snapshot()).at(camera) == glm::dvec3(1));
  Snapshot free_slots;
  free_slots.views.resize(3);
  free_slots.gains.assign(3, glm::dvec3(1));
  CHECK(NearbyExposure(free_slots).at(camera) == glm::dvec3(1));
  std::vector<PosedGain> views = scattered(20);
  for (PosedGain& view : views) view.gain = glm::dvec3(1);
  CHECK(NearbyExposure(snapshot_of(views, 2)).at(camera) == glm::dvec3(1));
}

TEST_CASE("at a stored view's pose the exposure is nearly that view's, however the others far away were exposed") {
  const NearbyExposure exposure(snapshot_of(far_apart(), 2));
  // The other view is 10 D away: q = 200, so its weight is below (0.01 / 200)^2 = 2.5e-9 of the nearer one's.
  CHECK(largest_difference(exposure.at(turned_camera({0, 0, 0}, 0)), glm::dvec3(2)) < 1e-7);
  CHECK(largest_difference(exposure.at(turned_camera({20, 0, 0}, 0)), glm::dvec3(0.5)) < 1e-7);
  CHECK(largest_difference(exposure.at(turned_camera({10, 0, 0}, 0)), glm::dvec3(1)) < 1e-12);  // between them
}

TEST_CASE("a view from the same place of something else is not nearby") {
  const NearbyExposure exposure(
      snapshot_of({{turned_camera({0, 0, 0}, 0), glm::dvec3(0.5)}, {turned_camera({0, 0, 0}, 2), glm::dvec3(2)}}, 2));
  CHECK(largest_difference(exposure.at(turned_camera({0, 0, 0}, 0)), glm::dvec3(2)) < 1e-3);
  CHECK(largest_difference(exposure.at(turned_camera({0, 0, 0}, 2)), glm::dvec3(0.5)) < 1e-3);
  CHECK(largest_difference(exposure.at(turned_camera({0, 0, 0}, 1)), glm::dvec3(1)) < 1e-12);
}

TEST_CASE("one stored view gives its exposure everywhere, each channel by itself, and free slots do not count") {
  const glm::dvec3 gain(0.25, 1.5, 3);
  Snapshot snapshot =
      snapshot_of({{turned_camera({0, 0, 0}, 0), glm::dvec3(1)}, {turned_camera({1, 2, 0}, 1), gain}}, 2);
  snapshot.views[0] = nullptr;
  const NearbyExposure exposure(snapshot);
  CHECK(largest_difference(exposure.at(turned_camera({1, 2, 0}, 1)), 1.0 / gain) < 1e-12);
  CHECK(largest_difference(exposure.at(turned_camera({-300, 5, 90}, -2)), 1.0 / gain) < 1e-12);
}

TEST_CASE("the exposure lies within those of the stored views, and close to the view whose pose it is asked for") {
  const std::vector<PosedGain> views = scattered(30);
  const NearbyExposure exposure(snapshot_of(views, 2));
  for (const PosedGain& view : views) {
    const glm::dvec3 e = exposure.at(view.camera);
    for (int channel = 0; channel < 3; ++channel) {
      CHECK((e[channel] > 0.25 && e[channel] < 4));
      CHECK(std::abs(std::log2(e[channel] * view.gain[channel])) < 0.25);  // stops, of the four that they differ by
    }
  }
}

TEST_CASE("along a path the exposure changes no faster than its header promises") {
  const std::vector<PosedGain> views = scattered(30);
  constexpr double kDepth = 2;
  const NearbyExposure exposure(snapshot_of(views, kDepth));
  constexpr int kSteps = 5000;
  const double moved = 4 * std::sqrt(3.0) / kSteps / kDepth;
  const double turned = 6.0 / kSteps;
  const double bound = std::log(16.0) * (15 * moved + 10 * turned);
  glm::dvec3 before = glm::log(exposure.at(turned_camera(glm::dvec3(0), -3)));
  double largest_step = 0;
  for (int step = 1; step <= kSteps; ++step) {
    const double along = static_cast<double>(step) / kSteps;
    const glm::dvec3 now = glm::log(exposure.at(turned_camera(glm::dvec3(4 * along), 6 * along - 3)));
    largest_step = std::max(largest_step, largest_difference(now, before));
    before = now;
  }
  CHECK(largest_step <= bound);
  CHECK(largest_step > 0);
}

TEST_CASE("the exposure does not depend on the scene's unit of length") {
  std::vector<PosedGain> views = scattered(12);
  Camera camera = turned_camera({1, 2, 3}, 0.4);
  const glm::dvec3 small = NearbyExposure(snapshot_of(views, 2)).at(camera);
  for (PosedGain& view : views) view.camera.cam_from_world_translation *= 1024.0;
  camera.cam_from_world_translation *= 1024.0;
  CHECK(largest_difference(NearbyExposure(snapshot_of(views, 2048)).at(camera), small) < 1e-12);
}

TEST_CASE("pixels without a surface do not count as depth, and without any surface the directions decide") {
  const Camera camera = turned_camera({3, 1, 0}, 0.1);
  Snapshot snapshot = snapshot_of(far_apart(), 2);
  const glm::dvec3 all_seen = NearbyExposure(snapshot).at(camera);
  const auto clear = [&](std::size_t first, std::size_t count) {
    for (auto& view : snapshot.views) {
      StoredView changed = *view;
      std::fill_n(own_mask(changed).depth.values().begin() + static_cast<std::ptrdiff_t>(first), count,
                  std::numeric_limits<float>::infinity());
      view = std::make_shared<const StoredView>(std::move(changed));
    }
  };
  clear(10, 38);
  CHECK(NearbyExposure(snapshot).at(camera) == all_seen);
  clear(0, 10);
  CHECK(largest_difference(NearbyExposure(snapshot).at(camera), glm::dvec3(1)) < 1e-12);  // both look the same way
}

TEST_CASE("an exposure that follows snapshots is that of the last one") {
  const Camera camera = turned_camera({3, 1, 0}, 0.1);
  Snapshot snapshot = snapshot_of(far_apart(), 2);
  NearbyExposure following(snapshot);
  const auto follows = [&] {
    following.follow(snapshot);
    return following.at(camera) == NearbyExposure(snapshot).at(camera) &&
           following.per_depth() == NearbyExposure(snapshot).per_depth();
  };
  const auto change = [&](std::size_t slot, float depth, double aside) {
    StoredView changed = *snapshot.views[slot];
    if (depth > 0) std::fill_n(own_mask(changed).depth.values().begin(), changed.mask->depth.size(), depth);
    changed.camera.cam_from_world_translation.x += aside;
    snapshot.views[slot] = std::make_shared<const StoredView>(std::move(changed));
  };
  CHECK(follows());
  change(0, 0, 0.5);
  CHECK(follows());
  for (std::size_t slot = 0; slot < snapshot.views.size(); ++slot) change(slot, 5, 0);
  CHECK(follows());
  snapshot.gains[0] = {2, 1, 1};
  CHECK(follows());
  const std::shared_ptr<const StoredView> last = snapshot.views.back();
  snapshot.views.back().reset();
  CHECK(follows());
  snapshot.views.back() = last;
  CHECK(follows());
  snapshot.gains[0] = {0, 1, 1};
  CHECK_THROWS_AS(following.follow(snapshot), std::invalid_argument);
}

TEST_CASE("the paper shows the common exposure of its views, and so does a picture on request") {
  const NearbyExposure exposure(snapshot_of(far_apart(), 2));
  const Camera camera = turned_camera({0, 0, 0}, 0);
  BlendOptions options;
  CHECK(picture_exposure(exposure, camera, options) == exposure.at(camera));
  options.exposure = BlendOptions::Exposure::model;
  CHECK(picture_exposure(exposure, camera, options) == glm::dvec3(1));
  CHECK(picture_exposure(exposure, camera, BlendOptions::printed()) == glm::dvec3(1));
}

}  // namespace
}  // namespace lumatlas
