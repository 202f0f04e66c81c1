// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/points_through_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "tools/base/process/interrupt.h"
#include "tools/inspection/blind_views.h"

namespace lumatlas {

namespace {

constexpr double kClearlyBefore = 0.95;  // depth of the mesh, as a share of the point's
constexpr std::size_t kLeastViewsOfPoint = 3;
constexpr std::size_t kLeastPointsOfView = 20;
constexpr std::size_t kMostViewsThrough = 100;

// Returns whether the mesh is clearly nearer than a point, on the point's pixel and all eight around it.
bool is_before(const VisibilityBuffer& visible, const Camera& camera, const glm::dvec3& point) {
  const glm::dvec3 cam = camera.cam_from_world(point);
  if (!(cam.z > 0)) return false;
  const glm::dvec2 at = camera.image_from_cam(cam);
  if (!(at.x >= 1 && at.y >= 1 && at.x < camera.width - 1.0 && at.y < camera.height - 1.0)) return false;
  const auto x = static_cast<std::size_t>(at.x), y = static_cast<std::size_t>(at.y);
  for (std::size_t row = y - 1; row <= y + 1; ++row) {
    for (std::size_t column = x - 1; column <= x + 1; ++column) {
      if (!(double{visible.depth[row * visible.width + column]} < kClearlyBefore * cam.z)) return false;
    }
  }
  return true;
}

// The points that a view saw, by their indices.
std::vector<std::vector<std::size_t>> points_by_view(const ScenePoints& points, std::size_t views) {
  std::vector<std::vector<std::size_t>> seen(views);
  for (std::size_t point = 0; point < points.views.size(); ++point) {
    if (points.views[point].size() < kLeastViewsOfPoint) continue;
    for (const std::uint32_t view : points.views[point]) {
      if (view < views) seen[view].push_back(point);
    }
  }
  return seen;
}

}  // namespace

std::vector<std::size_t> views_through_mesh(const ScenePoints& points, const std::vector<SceneView>& views,
                                            const std::vector<std::size_t>& ranks, const Visibility& visibility) {
  const std::vector<std::vector<std::size_t>> seen = points_by_view(points, views.size());
  std::vector<std::uint32_t> looked(points.positions.size(), 0), through(points.positions.size(), 0);
  VisibilityBuffer visible;
  for (const std::size_t rank : ranks) {
    throw_if_interrupted();
    if (seen[rank].empty()) continue;
    const Camera camera = views[rank].camera.shrunk_to(kGlancePx);
    visibility.trace(camera, visible);
    for (const std::size_t point : seen[rank]) {
      ++looked[point];
      if (is_before(visible, camera, points.positions[point])) ++through[point];
    }
  }
  std::vector<std::pair<std::size_t, std::size_t>> found;  // number of the other points, and rank
  for (const std::size_t rank : ranks) {
    const auto count =
        static_cast<std::size_t>(std::count_if(seen[rank].begin(), seen[rank].end(), [&](std::size_t point) {
          return looked[point] >= kLeastViewsOfPoint && through[point] == looked[point];
        }));
    if (count >= kLeastPointsOfView) found.emplace_back(points.positions.size() - count, rank);
  }
  if (found.size() < kLeastViewsOfPoint) return {};
  std::sort(found.begin(), found.end());
  found.resize(std::min(found.size(), kMostViewsThrough));
  std::vector<std::size_t> result;
  result.reserve(found.size());
  for (const auto& [count, rank] : found) result.push_back(rank);
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace lumatlas
