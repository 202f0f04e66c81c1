// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/estimated_views.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace lumatlas {
namespace {

constexpr double kPointsPerSquare = 4;
constexpr double kNearer = 1.1;       // how much deeper than what is before it a point may be
constexpr double kLeastFacing = 0.1;  // cosine between normal and line of sight
constexpr std::size_t kMostSquares = std::size_t{1} << 22;

struct Projected {
  std::uint32_t point;
  glm::dvec2 image;
  double depth;
};

std::vector<Projected> in_picture(std::span<const glm::dvec3> points, const Camera& view) {
  std::vector<Projected> result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::dvec3 cam = view.cam_from_world(points[i]);
    if (!(cam.z > 0)) continue;
    const glm::dvec2 image = view.image_from_cam(cam);
    if (image.x >= 0 && image.y >= 0 && image.x < view.width && image.y < view.height) {
      result.push_back({static_cast<std::uint32_t>(i), image, cam.z});
    }
  }
  return result;
}

// The least depth in each square of a picture.
class NearestDepths {
 public:
  NearestDepths(const Camera& view, const std::vector<Projected>& points) {
    const double pixels = static_cast<double>(view.width) * view.height;
    const double squares = std::clamp(static_cast<double>(points.size()) / kPointsPerSquare, 1.0, double{kMostSquares});
    side_px_ = std::sqrt(pixels / squares);
    columns_ = static_cast<int>(view.width / side_px_) + 1;
    rows_ = static_cast<int>(view.height / side_px_) + 1;
    depths_.assign(static_cast<std::size_t>(columns_) * rows_, std::numeric_limits<double>::infinity());
    for (const Projected& point : points) {
      double& depth = depths_[index(column(point), row(point))];
      depth = std::min(depth, point.depth);
    }
  }

  [[nodiscard]] bool hides(const Projected& point) const {
    for (int r = std::max(row(point) - 1, 0); r <= std::min(row(point) + 1, rows_ - 1); ++r) {
      for (int c = std::max(column(point) - 1, 0); c <= std::min(column(point) + 1, columns_ - 1); ++c) {
        if (point.depth > kNearer * depths_[index(c, r)]) return true;
      }
    }
    return false;
  }

 private:
  [[nodiscard]] int column(const Projected& point) const { return static_cast<int>(point.image.x / side_px_); }
  [[nodiscard]] int row(const Projected& point) const { return static_cast<int>(point.image.y / side_px_); }
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }

  double side_px_ = 1;
  int columns_ = 1, rows_ = 1;
  std::vector<double> depths_;
};

bool faces(const glm::vec3& normal, const glm::dvec3& to_view) {
  const glm::dvec3 wide(normal);
  return wide == glm::dvec3(0) || glm::dot(wide, to_view) > kLeastFacing * glm::length(to_view);
}

std::vector<std::uint32_t> points_seen(std::span<const glm::dvec3> points, std::span<const glm::vec3> normals,
                                       const Camera& view) {
  const std::vector<Projected> projected = in_picture(points, view);
  const NearestDepths nearest(view, projected);
  const glm::dvec3 center = view.center();
  std::vector<std::uint32_t> seen;
  for (const Projected& point : projected) {
    if (nearest.hides(point)) continue;
    if (!normals.empty() && !faces(normals[point.point], center - points[point.point])) continue;
    seen.push_back(point.point);
  }
  return seen;
}

// `count` of the list, evenly over it.
void keep_evenly(std::vector<std::uint32_t>& list, std::size_t count) {
  if (list.size() <= count) return;
  for (std::size_t i = 0; i < count; ++i) list[i] = list[i * list.size() / count];
  list.resize(count);
}

}  // namespace

std::vector<std::vector<std::uint32_t>> estimated_views(std::span<const glm::dvec3> points,
                                                        std::span<const glm::vec3> normals,
                                                        std::span<const Camera> views,
                                                        const std::function<void()>& progress) {
  std::vector<std::vector<std::uint32_t>> seen(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t view) {
    seen[view] = points_seen(points, normals, views[view]);
    progress();
  });
  std::vector<std::vector<std::uint32_t>> result(points.size());
  for (std::size_t view = 0; view < views.size(); ++view) {
    for (const std::uint32_t point : seen[view]) result[point].push_back(static_cast<std::uint32_t>(view));
    seen[view] = {};
  }
  for (std::vector<std::uint32_t>& list : result) keep_evenly(list, kMostEstimatedViews);
  return result;
}

}  // namespace lumatlas
