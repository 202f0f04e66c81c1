// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/stereo_neighbors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <utility>

#include "mesh/base/median.h"

namespace lumatlas {
namespace {

constexpr double kBestAngle = 8, kSigmaBelow = 4, kSigmaAbove = 15;  // degrees
constexpr double kLeastAngle = 0.2;                                  // degrees: below, any depth shows the same
constexpr std::size_t kMostPoints = 100'000;                         // that neighbors are chosen by
constexpr std::size_t kFewPoints = 20;                               // that say nothing of how far to look
constexpr double kNearerThanPoints = 1.6, kFartherThanPoints = 4;    // than the nearest and farthest of a camera's
constexpr double kDegrees = 57.29577951308232;

double angle_weight(double degrees) {
  if (degrees < kLeastAngle) return 0;
  const double away = (degrees - kBestAngle) / (degrees < kBestAngle ? kSigmaBelow : kSigmaAbove);
  return std::exp(-0.5 * away * away);
}

// Pixels a radian, over the picture's longer side: all photographs are compared at one size.
double sharpness(const Camera& camera, double depth) {
  return std::max(camera.fx, camera.fy) / std::max(camera.width, camera.height) / depth;
}

// Returns the pixel at which a camera sees a point; none: not in its picture.
std::optional<glm::dvec2> seen_at(const Camera& camera, const glm::dvec3& cam) {
  if (!(cam.z > 0)) return std::nullopt;
  const glm::dvec2 at = camera.image_from_cam(cam);
  if (!(at.x >= 0 && at.y >= 0 && at.x < camera.width && at.y < camera.height)) return std::nullopt;
  return at;
}

class Planner {
 public:
  Planner(std::span<const Camera> cameras, std::span<const glm::dvec3> points,
          std::span<const std::vector<std::uint32_t>> views)
      : cameras_(cameras), points_(points), seen_by_(cameras.size()) {
    for (const Camera& camera : cameras) centers_.push_back(camera.center());
    const bool noted = std::any_of(views.begin(), views.end(), [](const auto& list) { return !list.empty(); });
    if (noted)
      take_noted(views);
    else if (!points.empty())
      take_those_in_view();
  }

  [[nodiscard]] StereoPlan plan(std::size_t camera, std::size_t most_neighbors) const {
    std::vector<glm::dvec3> probes;
    for (const std::uint32_t point : seen_by_[camera]) probes.push_back(points_[point]);
    const bool has_points = probes.size() >= kFewPoints;
    if (!has_points) probes = probes_before(camera);
    StereoPlan plan;
    plan.neighbors = neighbors(camera, probes, has_points, most_neighbors);
    if (plan.neighbors.empty()) return plan;
    plan.range = has_points ? range_of(camera, probes) : range_by_neighbors(camera, plan.neighbors);
    if (has_points) plan.seeds = seeds(camera, probes, plan.range);
    return plan;
  }

 private:
  void take_noted(std::span<const std::vector<std::uint32_t>> views) {
    views_of_ = views;
    for (std::uint32_t point = 0; point < views.size(); ++point) {
      for (const std::uint32_t view : views[point]) seen_by_[view].push_back(point);
    }
  }

  void take_those_in_view() {
    const std::size_t every = (points_.size() + kMostPoints - 1) / kMostPoints;
    tbb::parallel_for(std::size_t{0}, cameras_.size(), [&](std::size_t camera) {
      for (std::size_t point = 0; point < points_.size(); point += every) {
        if (seen_at(cameras_[camera], cameras_[camera].cam_from_world(points_[point]))) {
          seen_by_[camera].push_back(static_cast<std::uint32_t>(point));
        }
      }
    });
  }

  [[nodiscard]] double distance_to_nearest(std::size_t camera) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& center : centers_) {
      const double distance = glm::distance(center, centers_[camera]);
      if (distance > 0) nearest = std::min(nearest, distance);
    }
    return nearest;
  }

  // Along rays through the picture, at distances from two to fifty of those between cameras.
  [[nodiscard]] std::vector<glm::dvec3> probes_before(std::size_t camera) const {
    const double unit = distance_to_nearest(camera);
    std::vector<glm::dvec3> probes;
    if (!std::isfinite(unit)) return probes;
    const Camera& view = cameras_[camera];
    for (double depth = 2; depth < 50; depth *= 1.5) {
      for (const double x : {0.2, 0.5, 0.8}) {
        for (const double y : {0.2, 0.5, 0.8}) {
          probes.push_back(centers_[camera] + unit * depth * view.ray({x * view.width, y * view.height}));
        }
      }
    }
    return probes;
  }

  [[nodiscard]] double benefit(std::size_t camera, std::size_t other, const glm::dvec3& point) const {
    const glm::dvec3 here = centers_[camera] - point, there = centers_[other] - point;
    const double cosine = glm::dot(glm::normalize(here), glm::normalize(there));
    const double depth = cameras_[camera].cam_from_world(point).z,
                 other_depth = cameras_[other].cam_from_world(point).z;
    if (!(depth > 0 && other_depth > 0)) return 0;
    const double ratio = sharpness(cameras_[camera], depth) / sharpness(cameras_[other], other_depth);
    return angle_weight(kDegrees * std::acos(std::clamp(cosine, -1.0, 1.0))) * std::min(ratio, 1 / ratio);
  }

  [[nodiscard]] std::vector<std::size_t> neighbors(std::size_t camera, const std::vector<glm::dvec3>& probes,
                                                   bool are_points, std::size_t most) const {
    std::vector<double> score(cameras_.size(), 0);
    const std::vector<std::uint32_t>& seen = seen_by_[camera];
    const std::size_t every = probes.size() / 2000 + 1;
    for (std::size_t i = 0; i < probes.size(); i += every) {
      if (are_points && !views_of_.empty()) {
        for (const std::uint32_t other : views_of_[seen[i]]) score[other] += benefit(camera, other, probes[i]);
        continue;
      }
      for (std::size_t other = 0; other < cameras_.size(); ++other) {
        if (other == camera || !seen_at(cameras_[other], cameras_[other].cam_from_world(probes[i]))) continue;
        score[other] += benefit(camera, other, probes[i]);
      }
    }
    score[camera] = 0;
    return best_of(score, most);
  }

  // A photograph with less than a hundredth of the best score shows too little of the same.
  static std::vector<std::size_t> best_of(const std::vector<double>& score, std::size_t most) {
    std::vector<std::size_t> order;
    const double best = *std::max_element(score.begin(), score.end());
    for (std::size_t i = 0; i < score.size(); ++i) {
      if (score[i] > 0.01 * best) order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return score[a] > score[b]; });
    order.resize(std::min(order.size(), most));
    return order;
  }

  [[nodiscard]] InverseDepthRange range_of(std::size_t camera, const std::vector<glm::dvec3>& points) const {
    std::vector<double> inverse;
    for (const glm::dvec3& point : points) {
      const double depth = cameras_[camera].cam_from_world(point).z;
      if (depth > 0) inverse.push_back(1 / depth);
    }
    const double least = percentile(inverse, 0.01) / kFartherThanPoints;
    const double most = percentile(std::move(inverse), 0.99) * kNearerThanPoints;
    return {static_cast<float>(least), static_cast<float>(most)};
  }

  // Down to where a pixel lies half a picture aside in the nearest neighbor.
  [[nodiscard]] InverseDepthRange range_by_neighbors(std::size_t camera,
                                                     const std::vector<std::size_t>& neighbors) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const std::size_t other : neighbors) {
      const double distance = glm::distance(centers_[other], centers_[camera]);
      if (distance > 0) nearest = std::min(nearest, distance);
    }
    const double depth = 2 * sharpness(cameras_[camera], 1) * nearest;
    return {static_cast<float>(0.002 / depth), static_cast<float>(1 / depth)};
  }

  [[nodiscard]] std::vector<DepthSeed> seeds(std::size_t camera, const std::vector<glm::dvec3>& points,
                                             const InverseDepthRange& range) const {
    const Camera& view = cameras_[camera];
    std::vector<DepthSeed> result;
    if (views_of_.empty()) return result;  // without this list hidden points cannot be found
    for (const glm::dvec3& point : points) {
      const glm::dvec3 cam = view.cam_from_world(point);
      const std::optional<glm::dvec2> at = seen_at(view, cam);
      const auto w = static_cast<float>(1 / cam.z);
      if (!at || w < range.least || w > range.most) continue;
      result.push_back({glm::vec2(at->x / view.width, at->y / view.height), w});
    }
    return result;
  }

  std::span<const Camera> cameras_;
  std::span<const glm::dvec3> points_;
  std::span<const std::vector<std::uint32_t>> views_of_;
  std::vector<std::vector<std::uint32_t>> seen_by_;  // the points of each camera
  std::vector<glm::dvec3> centers_;
};

}  // namespace

std::vector<StereoPlan> plan_stereo(std::span<const Camera> cameras, std::span<const glm::dvec3> points,
                                    std::span<const std::vector<std::uint32_t>> views, std::size_t most_neighbors) {
  const Planner planner(cameras, points, views);
  std::vector<StereoPlan> plans(cameras.size());
  tbb::parallel_for(std::size_t{0}, cameras.size(),
                    [&](std::size_t camera) { plans[camera] = planner.plan(camera, most_neighbors); });
  return plans;
}

}  // namespace lumatlas
