// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/nearby_sight.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <utility>

namespace lumatlas {

namespace {

constexpr float kSmooth = 0.05f;  // share of the nearer depth: neighbours that differ by no more show one surface

// Depth of a view's image between its pixels' centres.
class DepthImage {
 public:
  explicit DepthImage(const StoredView& view) : view_(view) {}

  // Returns nothing outside the image.
  [[nodiscard]] std::optional<std::size_t> pixel_at(const glm::dvec2& image) const {
    if (!(image.x >= 0 && image.y >= 0 && image.x < view_.camera.width && image.y < view_.camera.height)) return {};
    return static_cast<std::size_t>(image.y) * view_.camera.width + static_cast<std::size_t>(image.x);
  }

  // The reciprocal of depth is linear over a plane. The nearest pixel's where its neighbours are no smooth surface.
  [[nodiscard]] float depth_at(const glm::dvec2& image) const {
    const auto [left, across] = between(image.x, view_.camera.width);
    const auto [top, down] = between(image.y, view_.camera.height);
    const std::size_t right = std::min<std::size_t>(left + 1, view_.camera.width - 1);
    const std::size_t bottom = std::min<std::size_t>(top + 1, view_.camera.height - 1);
    const std::size_t width = view_.camera.width;
    const std::array<float, 4> z = {view_.mask->depth[top * width + left], view_.mask->depth[top * width + right],
                                    view_.mask->depth[bottom * width + left],
                                    view_.mask->depth[bottom * width + right]};
    const auto [nearest, farthest] = std::minmax_element(z.begin(), z.end());
    if (!(*farthest - *nearest <= kSmooth * *nearest)) return view_.mask->depth[*pixel_at(image)];
    const float above = (1 - across) / z[0] + across / z[1];
    const float below = (1 - across) / z[2] + across / z[3];
    return 1 / ((1 - down) * above + down * below);
  }

 private:
  // The pixel whose centre comes before a position along an axis, and how far it is from there to the next one.
  static std::pair<std::size_t, float> between(double position, std::uint32_t pixels) {
    const double from_first = std::clamp(position - 0.5, 0.0, pixels - 1.0);
    const double before = std::floor(from_first);
    return {static_cast<std::size_t>(before), static_cast<float>(from_first - before)};
  }

  const StoredView& view_;
};

}  // namespace

VisibilityBuffer seen_nearby(const StoredView& view, const FaceLookup& faces, const Camera& camera) {
  check(camera);
  VisibilityBuffer seen{camera.width, camera.height, {}, {}};
  seen.depth.assign(std::size_t{camera.width} * camera.height, std::numeric_limits<float>::infinity());
  seen.face.assign(seen.depth.size(), FaceId::none);
  const DepthImage image(view);
  const glm::dvec3 center = camera.center();
  const double to_width = static_cast<double>(view.camera.width) / camera.width;
  const double to_height = static_cast<double>(view.camera.height) / camera.height;
  tbb::parallel_for(0u, camera.height, [&](std::uint32_t y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      const glm::dvec2 pixel(x + 0.5, y + 0.5);
      const float guess = image.depth_at({pixel.x * to_width, pixel.y * to_height});
      if (!std::isfinite(guess)) continue;
      const glm::dvec3 cam = view.camera.cam_from_world(center + static_cast<double>(guess) * camera.ray(pixel));
      if (!(cam.z > 0)) continue;
      const glm::dvec2 place = view.camera.image_from_cam(cam);
      const std::optional<std::size_t> own = image.pixel_at(place);
      if (!own) continue;
      const float depth = image.depth_at(place);
      if (!std::isfinite(depth)) continue;
      const std::size_t index = std::size_t{y} * camera.width + x;
      seen.depth[index] = guess * static_cast<float>(depth / cam.z);
      seen.face[index] = faces.at(*own);
    }
  });
  return seen;
}

}  // namespace lumatlas
