// SPDX-License-Identifier: GPL-3.0-or-later
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <vector>

#include "mesh/cells.h"
#include "mesh/face_areas.h"

namespace lumatlas {

namespace {

constexpr double kOutermostShare = 0.01;  // of the area, on each side of each axis

// A face along one axis: its corners' coordinates in ascending order, and its area.
struct Slab {
  double low, middle, high, area;
};

std::vector<Slab> slabs_along(const Mesh& mesh, const std::vector<double>& areas, int axis) {
  std::vector<Slab> slabs;
  slabs.reserve(mesh.faces.size());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const glm::uvec3& face = mesh.faces[i];
    std::array<float, 3> at{mesh.positions[face.x][axis], mesh.positions[face.y][axis], mesh.positions[face.z][axis]};
    std::sort(at.begin(), at.end());
    slabs.push_back({at[0], at[1], at[2], areas[i]});
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

double extent_along(const Mesh& mesh, const std::vector<double>& areas, double total, int axis) {
  const std::vector<Slab> slabs = slabs_along(mesh, areas, axis);
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Slab& slab : slabs) {
    low = std::min(low, slab.low);
    high = std::max(high, slab.high);
  }
  const double first = coordinate_with_area_below(slabs, low, high, kOutermostShare * total);
  const double last = coordinate_with_area_below(slabs, low, high, (1 - kOutermostShare) * total);
  return std::max(last - first, 0.0);
}

}  // namespace

double scene_diameter(const Mesh& mesh) {
  if (mesh.faces.empty()) return 0;
  const std::vector<double> areas = face_areas(mesh);
  const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
  glm::dvec3 extent(0);
  tbb::parallel_for(0, 3, [&](int axis) { extent[axis] = extent_along(mesh, areas, total, axis); });
  return glm::length(extent);
}

}  // namespace lumatlas
