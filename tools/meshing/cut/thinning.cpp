// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/cut/thinning.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <unordered_map>

#include "mesh/base/number_text.h"

namespace lumatlas {
namespace {

// Returns the width of a pixel of the nearest view at the point; 0 if no view saw it.
double pixel_width(const glm::dvec3& point, const std::vector<std::uint32_t>& seen_by, std::span<const Camera> views) {
  double least = std::numeric_limits<double>::infinity();
  for (const std::uint32_t view : seen_by) {
    least = std::min(least, glm::distance(views[view].center(), point) / std::max(views[view].fx, views[view].fy));
  }
  return std::isfinite(least) ? least : 0;
}

// Points by the cube of space that they lie in. Cubes have sides of powers of two, so that near and far points, whose
// pixels differ in width, each have cubes of their own size.
class Cubes {
 public:
  // The point of the list that is nearest to `position` within `radius`, of those that were added with a radius of
  // the same power of two or of the next ones; kNone if there is none.
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  [[nodiscard]] std::uint32_t nearest(const glm::dvec3& position, double radius, const ScenePoints& points) const {
    const int level = level_of(radius);
    std::uint32_t best = kNone;
    double best_distance = radius;
    for (const int at : {level - 1, level, level + 1}) {
      const double side = std::ldexp(1.0, at);
      const std::array low = cube(position - glm::dvec3(radius), side),
                       high = cube(position + glm::dvec3(radius), side);
      for (std::int64_t x = low[0]; x <= high[0]; ++x) {
        for (std::int64_t y = low[1]; y <= high[1]; ++y) {
          for (std::int64_t z = low[2]; z <= high[2]; ++z) {
            const auto found = points_in_.find(key({x, y, z}, at));
            if (found == points_in_.end()) continue;
            for (const std::uint32_t point : found->second) {
              const double distance = glm::distance(points.positions[point], position);
              if (distance < best_distance || (distance == best_distance && point < best)) {
                best = point;
                best_distance = distance;
              }
            }
          }
        }
      }
    }
    return best;
  }

  void add(std::uint32_t point, const glm::dvec3& position, double radius) {
    const int level = level_of(radius);
    points_in_[key(cube(position, std::ldexp(1.0, level)), level)].push_back(point);
  }

 private:
  using Place = std::array<std::int64_t, 3>;

  // 2^level is at least the radius, and less than twice it.
  static int level_of(double radius) {
    int level = 0;
    std::frexp(radius, &level);
    return level;
  }
  static Place cube(const glm::dvec3& position, double side) {
    Place place;
    for (int axis = 0; axis < 3; ++axis) {
      place[static_cast<std::size_t>(axis)] =
          static_cast<std::int64_t>(std::floor(std::clamp(position[axis] / side, -9e18, 9e18)));
    }
    return place;
  }
  // Cubes that share a key by chance share a list, which costs time alone.
  static std::uint64_t key(const Place& place, int level) {
    std::uint64_t hash = static_cast<std::uint64_t>(level);
    for (const std::int64_t coordinate : place) {
      hash = (hash ^ static_cast<std::uint64_t>(coordinate)) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 29;
    }
    return hash;
  }

  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> points_in_;
};

void merge(std::vector<std::uint32_t>& into, const std::vector<std::uint32_t>& from) {
  std::vector<std::uint32_t> both;
  std::set_union(into.begin(), into.end(), from.begin(), from.end(), std::back_inserter(both));
  into = std::move(both);
}

}  // namespace

ScenePoints thinned(const ScenePoints& points, std::span<const Camera> views, double spacing_px) {
  if (!(spacing_px >= 0 && std::isfinite(spacing_px))) {
    throw std::invalid_argument("spacing_px: " + number_text(spacing_px) + ", must be finite and not negative");
  }
  std::vector<std::uint32_t> order(points.positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return points.views[a].size() > points.views[b].size(); });
  ScenePoints result{points.file, {}, {}, {}, {}};
  Cubes cubes;
  for (const std::uint32_t i : order) {
    if (points.views[i].empty()) break;
    const double radius = spacing_px * pixel_width(points.positions[i], points.views[i], views);
    const std::uint32_t near = radius > 0 ? cubes.nearest(points.positions[i], radius, result) : Cubes::kNone;
    if (near != Cubes::kNone) {
      merge(result.views[near], points.views[i]);
      continue;
    }
    if (radius > 0) cubes.add(static_cast<std::uint32_t>(result.positions.size()), points.positions[i], radius);
    result.positions.push_back(points.positions[i]);
    if (!points.colors.empty()) result.colors.push_back(points.colors[i]);
    if (!points.normals.empty()) result.normals.push_back(points.normals[i]);
    if (!points.deviations.empty()) result.deviations.push_back(points.deviations[i]);
    result.views.push_back(points.views[i]);
  }
  return result;
}

}  // namespace lumatlas
