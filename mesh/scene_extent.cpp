// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/scene_extent.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace lumatlas {

namespace {

constexpr double kOutermostShare = 0.01;  // of the area, on each side of each axis
constexpr double kMostStretch = 2;        // of the diameter by the faces at stray vertices

// A face along one axis: its corners' coordinates in ascending order, and the area that it counts for.
struct Slab {
  double low, middle, high, area;
};

std::vector<Slab> slabs_along(const Mesh& mesh, const std::vector<double>& weights, int axis) {
  std::vector<Slab> slabs;
  slabs.reserve(mesh.faces.size());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const glm::uvec3& face = mesh.faces[i];
    std::array<float, 3> at{mesh.positions[face.x][axis], mesh.positions[face.y][axis], mesh.positions[face.z][axis]};
    std::sort(at.begin(), at.end());
    slabs.push_back({at[0], at[1], at[2], weights[i]});
  }
  return slabs;
}

// The width of a triangle across an axis grows linearly from its lowest corner to the middle one and falls linearly to
// the highest, so that the area below t is quadratic in t on both sides of the middle.
double area_below(const Slab& slab, double t) {
  if (t <= slab.low) return 0;
  if (t >= slab.high) return slab.area;
  const double extent = slab.high - slab.low;
  if (t < slab.middle) return slab.area * (t - slab.low) * (t - slab.low) / ((slab.middle - slab.low) * extent);
  return slab.area * (1 - (slab.high - t) * (slab.high - t) / ((slab.high - slab.middle) * extent));
}

// Where the area below reaches `wanted`, by bisection. Faces that the bracket has left behind are dropped on the way,
// so that the whole search costs little more than one pass.
double coordinate_with_area_below(std::vector<Slab> slabs, double low, double high, double wanted) {
  constexpr int kMostHalvings = 100;  // enough for the central part to be exact when strays are 1e15 times as far away
  double settled = 0;                 // area of the faces below the bracket
  for (int halving = 0; halving < kMostHalvings; ++halving) {
    const double middle = low + (high - low) / 2;
    if (middle <= low || middle >= high) break;
    const double below = std::accumulate(slabs.begin(), slabs.end(), settled,
                                         [&](double sum, const Slab& slab) { return sum + area_below(slab, middle); });
    (below < wanted ? low : high) = middle;
    std::erase_if(slabs, [&](const Slab& slab) {
      if (slab.high <= low) settled += slab.area;
      return slab.high <= low || slab.low >= high;
    });
  }
  return low + (high - low) / 2;
}

struct Interval {
  double low = 0, high = 0;
};

Interval core_along(const Mesh& mesh, const std::vector<double>& weights, double total, int axis) {
  const std::vector<Slab> slabs = slabs_along(mesh, weights, axis);
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Slab& slab : slabs) {
    low = std::min(low, slab.low);
    high = std::max(high, slab.high);
  }
  const double first = coordinate_with_area_below(slabs, low, high, kOutermostShare * total);
  const double last = coordinate_with_area_below(slabs, low, high, (1 - kOutermostShare) * total);
  return {first, std::max(last, first)};
}

// `weights` are the areas that the faces count for.
SceneExtent extent_by(const Mesh& mesh, const std::vector<double>& weights) {
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  SceneExtent extent;
  tbb::parallel_for(0, 3, [&](int axis) {
    const Interval core = core_along(mesh, weights, total, axis);
    extent.core.min[axis] = core.low;
    extent.core.max[axis] = core.high;
  });
  extent.diameter = glm::length(extent.core.max - extent.core.min);
  return extent;
}

// The corner of a spike that lies far away from the two others; nothing if the face is no spike: if it is not 100 times
// as high as its shortest edge is long.
std::optional<std::uint32_t> tip_of(const Mesh& mesh, const glm::uvec3& face, double area) {
  constexpr double kMostArea = 50;        // of the squared shortest edge
  std::array<double, 3> squared_edges{};  // opposite to each corner
  for (int corner = 0; corner < 3; ++corner) {
    const glm::dvec3 edge =
        glm::dvec3(mesh.positions[face[(corner + 1) % 3]]) - glm::dvec3(mesh.positions[face[(corner + 2) % 3]]);
    squared_edges[static_cast<std::size_t>(corner)] = glm::dot(edge, edge);
  }
  const auto shortest = std::min_element(squared_edges.begin(), squared_edges.end());
  if (!(area > kMostArea * *shortest)) return std::nullopt;
  return face[static_cast<int>(shortest - squared_edges.begin())];
}

// The faces at stray vertices: spikes, and those between two stray vertices that are neighbours, which may have any
// shape. Of a vertex that has strayed every face is such a one.
std::vector<std::uint8_t> faces_at_strays(const Mesh& mesh, std::span<const FaceGeometry> geometry) {
  std::vector<std::optional<std::uint32_t>> tips(mesh.faces.size());
  std::vector<std::uint8_t> may_be_stray(mesh.positions.size(), 0);
  for (std::size_t i = 0; i < tips.size(); ++i) {
    tips[i] = tip_of(mesh, mesh.faces[i], geometry[i].area);
    if (tips[i]) may_be_stray[*tips[i]] = 1;
  }
  const auto strays_of = [&](const glm::uvec3& face) {
    return may_be_stray[face.x] + may_be_stray[face.y] + may_be_stray[face.z];
  };
  std::vector<std::uint8_t> is_stray = may_be_stray;
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const glm::uvec3& face = mesh.faces[i];
    if (strays_of(face) > 1) continue;
    for (int corner = 0; corner < 3; ++corner) {
      if (tips[i] != face[corner]) is_stray[face[corner]] = 0;  // a face as others have
    }
  }
  std::vector<std::uint8_t> chosen(tips.size());
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const glm::uvec3& face = mesh.faces[i];
    chosen[i] = tips[i] || is_stray[face.x] + is_stray[face.y] + is_stray[face.z] > 1;
  }
  return chosen;
}

}  // namespace

SceneExtent scene_extent(const Mesh& mesh, std::span<const FaceGeometry> geometry) {
  if (mesh.faces.empty()) return {};
  std::vector<double> weights(geometry.size());
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = geometry[i].area;
  const SceneExtent by_area = extent_by(mesh, weights);
  const std::vector<std::uint8_t> at_strays = faces_at_strays(mesh, geometry);
  double discounted = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (at_strays[i]) discounted += std::exchange(weights[i], 0);
  }
  const double total = std::accumulate(weights.begin(), weights.end(), discounted);
  if (discounted < 0.1 * kOutermostShare * total) return by_area;  // too little to move any of its sides far
  const SceneExtent without_strays = extent_by(mesh, weights);
  return by_area.diameter > kMostStretch * without_strays.diameter && without_strays.diameter > 0 ? without_strays
                                                                                                  : by_area;
}

SceneExtent scene_extent(const Mesh& mesh) {
  check(mesh);
  return scene_extent(mesh, face_geometry(mesh));
}

double scene_diameter(const Mesh& mesh) {
  return scene_extent(mesh).diameter;
}

}  // namespace lumatlas
