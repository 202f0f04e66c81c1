// SPDX-License-Identifier: GPL-3.0-or-later
// Depths of a wall whose true depths are known.
#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <string>

#include "tests/support/scenes/relief_scenes.h"
#include "tools/stereo/agreeing_depths.h"
#include "tools/stereo/patch_match.h"
#include "tools/stereo/stereo_neighbors.h"

namespace lumatlas {
namespace {

// Five photographs from an arc and what stereo finds in them.
struct MatchedRelief {
  Relief relief;
  std::vector<Camera> cameras;
  std::vector<LumaPyramid> pyramids;
  InverseDepthRange range{0.1F, 0.5F};

  explicit MatchedRelief(bool masked = false) {
    for (const double degrees : {-12.0, -6.0, 0.0, 6.0, 12.0}) {
      cameras.push_back(camera_on_arc(degrees));
      Photograph photograph = relief.photograph(cameras.back());
      if (masked) {
        photograph.valid.assign(photograph.rgb.size() / 3, 255);
        for (std::size_t y = 0; y < 180; ++y) {
          for (std::size_t x = 0; x < 120; ++x) photograph.valid[y * 240 + x] = 0;
        }
      }
      pyramids.push_back(luma_pyramid(photograph, cameras.back(), 240, 60));
    }
  }

  [[nodiscard]] MatchedViews views(std::size_t reference) const {
    MatchedViews result{&pyramids[reference], {}};
    for (std::size_t i = 0; i < pyramids.size(); ++i) {
      if (i != reference) result.others.push_back(&pyramids[i]);
    }
    return result;
  }

  [[nodiscard]] std::vector<StereoDepth> depths() const {
    std::vector<PlaneMap> first, second;
    for (std::size_t i = 0; i < cameras.size(); ++i) first.push_back(match_patches(views(i), range, {}));
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      std::vector<const PlaneMap*> others;
      for (std::size_t j = 0; j < cameras.size(); ++j) {
        if (j != i) others.push_back(&first[j]);
      }
      second.push_back(match_consistently(views(i), range, first[i], others));
    }
    std::vector<StereoDepth> result;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      std::vector<PosedPlanes> others;
      for (std::size_t j = 0; j < cameras.size(); ++j) {
        if (j != i) others.push_back({cameras[j], &second[j]});
      }
      result.push_back(agreeing_depths({cameras[i], &second[i]}, others, {}));
    }
    return result;
  }

  [[nodiscard]] std::vector<float> true_depth(std::size_t view) const {
    return relief.visibility->trace(cameras[view]).depth;
  }
};

// How many pixels a depth is off in the photograph beside, and in its own standard deviations.
struct Errors {
  std::size_t known = 0, of = 0, within_half_px = 0, within_px = 0, within_2_px = 0, within_1 = 0, within_2 = 0;

  void add(const StereoDepth& found, const std::vector<float>& truth, const Camera& beside) {
    const PixelTransfer transfer = pixel_transfer(found.camera, beside);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (!std::isfinite(truth[i])) continue;
      ++of;
      if (!(found.depth[i] > 0)) continue;
      ++known;
      const std::size_t x = i % 240, y = i / 240;
      const glm::vec2 pixel(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
      const auto place = [&](float depth) {
        const glm::vec3 at = transfer.homogeneous(pixel, 1 / depth);
        return glm::vec2(at) / at.z;
      };
      const glm::vec2 way = place(found.depth[i]) - place(truth[i]);
      const float px = std::hypot(way.x, way.y), deviations = std::abs(found.depth[i] - truth[i]) / found.deviation[i];
      within_half_px += px < 0.5F ? 1 : 0;
      within_px += px < 1 ? 1 : 0;
      within_2_px += px < 2 ? 1 : 0;
      within_1 += deviations < 1 ? 1 : 0;
      within_2 += deviations < 2 ? 1 : 0;
    }
  }
  [[nodiscard]] double share(std::size_t count) const {
    return static_cast<double>(count) / static_cast<double>(known);
  }
};

TEST_CASE("nearly all depths of a textured wall are found within half a pixel, and the deviation says how well") {
  const MatchedRelief relief;
  const std::vector<StereoDepth> found = relief.depths();
  Errors errors, of_all;
  errors.add(found[2], relief.true_depth(2), relief.cameras[4]);
  for (std::size_t i = 0; i < found.size(); ++i)
    of_all.add(found[i], relief.true_depth(i), relief.cameras[i < 3 ? 4 : 0]);
  INFO("known " << errors.known << " of " << errors.of << ", within half a pixel "
                << errors.share(errors.within_half_px) << ", a pixel " << errors.share(errors.within_px)
                << ", 2 pixels " << errors.share(errors.within_2_px) << "; of all photographs within 1 deviation "
                << of_all.share(of_all.within_1) << ", 2 " << of_all.share(of_all.within_2));
  CHECK(static_cast<double>(errors.known) > 0.9 * static_cast<double>(errors.of));
  CHECK(errors.share(errors.within_half_px) > 0.85);
  CHECK(errors.share(errors.within_px) > 0.92);
  CHECK(errors.share(errors.within_2_px) > 0.96);
  // If errors were normally distributed, 68 % would be within one standard deviation and 95 % within two.
  CHECK(of_all.share(of_all.within_1) > 0.58);
  CHECK(of_all.share(of_all.within_2) > 0.8);
}

TEST_CASE("masked pixels have no depth") {
  const MatchedRelief relief(true);
  const StereoDepth found = relief.depths()[2];
  std::size_t masked = 0, known = 0;
  for (std::size_t i = 0; i < found.depth.size(); ++i) {
    if (!(found.depth[i] > 0)) continue;
    ++known;
    masked += i % 240 < 120 ? 1 : 0;
  }
  CHECK(masked == 0);
  CHECK(known > 10'000);
}

TEST_CASE("one thread finds the planes that many find") {
  const MatchedRelief relief;
  const PlaneMap many = match_patches(relief.views(2), relief.range, {});
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  const PlaneMap one = match_patches(relief.views(2), relief.range, {});
  CHECK(std::memcmp(many.planes.data(), one.planes.data(), one.planes.size() * sizeof(SlantedPlane)) == 0);
  CHECK(many.costs == one.costs);
}

TEST_CASE("a way to the other photograph and back ends where it began, if its plane is the same surface") {
  const Camera here = camera_on_arc(0), there = camera_on_arc(8);
  PlaneMap planes{240, 180, std::vector<SlantedPlane>(240 * 180), std::vector<float>(240 * 180)};
  const glm::vec2 pixel(120.5F, 90.5F);
  const PixelTransfer to = pixel_transfer(here, there), back = pixel_transfer(there, here);
  CHECK(std::isinf(way_back_px(pixel, 0.25F, to, back, planes)));  // no plane
  const glm::dvec3 point = here.center() + 4.0 * here.ray(glm::dvec2(pixel));
  for (SlantedPlane& plane : planes.planes) plane.w = static_cast<float>(1 / there.cam_from_world(point).z);
  CHECK(way_back_px(pixel, 0.25F, to, back, planes) < 0.01F);
  for (SlantedPlane& plane : planes.planes) plane.w *= 1.1F;
  CHECK(way_back_px(pixel, 0.25F, to, back, planes) > 1);
  CHECK(std::isinf(way_back_px(pixel, 5, to, back, planes)));  // out of its picture
}

}  // namespace
}  // namespace lumatlas
