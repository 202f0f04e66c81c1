// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/scene_extent.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <vector>

#include "mesh/face_geometry.h"

namespace lumatlas {

namespace {

constexpr double kOutermostShare = 0.01;  // share of the area, on each side of each axis
constexpr double kMostStretch = 2;        // share of the diameter by the faces at stray vertices

// A face along one axis: its corners' coordinates in ascending order, and the area that it counts for.
struct Slab {
  double low, middle, high, area;
};

// The faces of a mesh and the areas that they count for: those at stray vertices, if any are named, for none.
struct WeighedFaces {
  const Mesh& mesh;
  std::span<const double> areas;
  std::span<const std::uint8_t> left_out;  // one per face, or empty

  [[nodiscard]] std::size_t size() const { return mesh.faces.size(); }
  [[nodiscard]] double area(std::size_t i) const { return left_out.empty() || !left_out[i] ? areas[i] : 0; }
  [[nodiscard]] Slab slab(std::size_t i, int axis) const {
    const glm::uvec3& face = mesh.faces[i];
    std::array<float, 3> at{mesh.positions[face.x][axis], mesh.positions[face.y][axis], mesh.positions[face.z][axis]};
    std::sort(at.begin(), at.end());
    return {at[0], at[1], at[2], area(i)};
  }
};

// The width of a triangle across an axis grows linearly from its lowest corner to the middle one and falls linearly to
// the highest, so that the area below t is quadratic in t on both sides of the middle.
double area_below(const Slab& slab, double t) {
  if (t <= slab.low) return 0;
  if (t >= slab.high) return slab.area;
  const double extent = slab.high - slab.low;
  if (t < slab.middle) return slab.area * (t - slab.low) * (t - slab.low) / ((slab.middle - slab.low) * extent);
  return slab.area * (1 - (slab.high - t) * (slab.high - t) / ((slab.high - slab.middle) * extent));
}

// The faces that a bisection still has to look at, in ascending order: a bit for each of the mesh's at first, and their
// slabs once these take less memory than a byte or two a face.
class OpenFaces {
 public:
  OpenFaces(const WeighedFaces& faces, int axis)
      : faces_(faces), axis_(axis), open_(faces.size(), true), count_(faces.size()) {}

  template <typename Function>
  void for_each(const Function& function) const {
    for (const Slab& slab : slabs_) function(slab);
    for (std::size_t i = 0; i < open_.size(); ++i) {
      if (open_[i]) function(faces_.slab(i, axis_));
    }
  }

  template <typename Predicate>
  void erase_if(const Predicate& is_done) {
    std::erase_if(slabs_, is_done);
    for (std::size_t i = 0; i < open_.size(); ++i) {
      if (!open_[i] || !is_done(faces_.slab(i, axis_))) continue;
      open_[i] = false;
      --count_;
    }
    if (!open_.empty() && count_ <= faces_.size() / kFacesASlab) keep_slabs();
  }

 private:
  static constexpr std::size_t kFacesASlab = 16;  // 2 bytes of slabs a face

  void keep_slabs() {
    slabs_.reserve(count_);
    for (std::size_t i = 0; i < open_.size(); ++i) {
      if (open_[i]) slabs_.push_back(faces_.slab(i, axis_));
    }
    open_ = {};
  }

  const WeighedFaces& faces_;
  int axis_;
  std::vector<bool> open_;
  std::size_t count_;
  std::vector<Slab> slabs_;
};

struct Interval {
  double low = 0, high = 0;
};

// Returns the coordinate where the area below reaches `wanted`, by bisection of `range`. Faces outside the bracket are
// dropped on the way, so that the whole search costs little more than some passes.
double coordinate_with_area_below(const WeighedFaces& faces, int axis, const Interval& range, double wanted) {
  constexpr int kMostHalvings = 100;  // enough for the central part to be exact when strays are 1e15 times as far away
  auto [low, high] = range;
  OpenFaces open(faces, axis);
  double settled = 0;  // area of the faces below the bracket
  for (int halving = 0; halving < kMostHalvings; ++halving) {
    const double middle = low + (high - low) / 2;
    if (middle <= low || middle >= high) break;
    double below = settled;
    open.for_each([&](const Slab& slab) { below += area_below(slab, middle); });
    (below < wanted ? low : high) = middle;
    open.erase_if([&, low = low, high = high](const Slab& slab) {
      if (slab.high <= low) settled += slab.area;
      return slab.high <= low || slab.low >= high;
    });
  }
  return low + (high - low) / 2;
}

Interval core_along(const WeighedFaces& faces, double total, int axis) {
  Interval range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const Slab slab = faces.slab(i, axis);
    range.low = std::min(range.low, slab.low);
    range.high = std::max(range.high, slab.high);
  }
  const double first = coordinate_with_area_below(faces, axis, range, kOutermostShare * total);
  const double last = coordinate_with_area_below(faces, axis, range, (1 - kOutermostShare) * total);
  return {first, std::max(last, first)};
}

SceneExtent extent_by(const WeighedFaces& faces) {
  double total = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) total += faces.area(i);
  SceneExtent extent;
  tbb::parallel_for(0, 3, [&](int axis) {
    const Interval core = core_along(faces, total, axis);
    extent.core.min[axis] = core.low;
    extent.core.max[axis] = core.high;
  });
  extent.diameter = glm::length(extent.core.max - extent.core.min);
  return extent;
}

// Returns the corner of a spike that lies far away from the two others, 0 to 2; kNoTip if the face is no spike: if it
// is not 100 times as high as its shortest edge is long.
constexpr std::uint8_t kNoTip = 3;
std::uint8_t tip_of(const Mesh& mesh, const glm::uvec3& face, double area) {
  constexpr double kMostArea = 50;        // multiple of the squared shortest edge
  std::array<double, 3> squared_edges{};  // opposite to each corner
  for (int corner = 0; corner < 3; ++corner) {
    const glm::dvec3 edge =
        glm::dvec3(mesh.positions[face[(corner + 1) % 3]]) - glm::dvec3(mesh.positions[face[(corner + 2) % 3]]);
    squared_edges[static_cast<std::size_t>(corner)] = glm::dot(edge, edge);
  }
  const auto shortest = std::min_element(squared_edges.begin(), squared_edges.end());
  if (!(area > kMostArea * *shortest)) return kNoTip;
  return static_cast<std::uint8_t>(shortest - squared_edges.begin());
}

// The faces at stray vertices: spikes, and those between two stray vertices that are neighbours, which may have any
// shape. Every face at a vertex that has strayed is one of these.
std::vector<std::uint8_t> faces_at_strays(const Mesh& mesh, std::span<const double> areas) {
  std::vector<std::uint8_t> tips(mesh.faces.size());
  std::vector<std::uint8_t> may_be_stray(mesh.positions.size(), 0);
  for (std::size_t i = 0; i < tips.size(); ++i) {
    tips[i] = tip_of(mesh, mesh.faces[i], areas[i]);
    if (tips[i] != kNoTip) may_be_stray[mesh.faces[i][tips[i]]] = 1;
  }
  const auto strays_of = [&](const glm::uvec3& face) {
    return may_be_stray[face.x] + may_be_stray[face.y] + may_be_stray[face.z];
  };
  std::vector<std::uint8_t> is_stray = may_be_stray;
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const glm::uvec3& face = mesh.faces[i];
    if (strays_of(face) > 1) continue;
    for (int corner = 0; corner < 3; ++corner) {
      if (tips[i] == kNoTip || face[tips[i]] != face[corner]) is_stray[face[corner]] = 0;  // a face as others have
    }
  }
  std::vector<std::uint8_t>& chosen = tips;  // a tip is looked up once more, for the face that it belongs to
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const glm::uvec3& face = mesh.faces[i];
    chosen[i] = tips[i] != kNoTip || is_stray[face.x] + is_stray[face.y] + is_stray[face.z] > 1;
  }
  return chosen;
}

}  // namespace

SceneExtent scene_extent(const Mesh& mesh, std::span<const double> areas) {
  if (mesh.faces.empty()) return {};
  const SceneExtent by_area = extent_by({mesh, areas, {}});
  const std::vector<std::uint8_t> at_strays = faces_at_strays(mesh, areas);
  const WeighedFaces others{mesh, areas, at_strays};
  double discounted = 0;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    if (at_strays[i]) discounted += areas[i];
  }
  double total = discounted;
  for (std::size_t i = 0; i < areas.size(); ++i) total += others.area(i);
  if (discounted < 0.1 * kOutermostShare * total) return by_area;  // too little to move any of its sides far
  const SceneExtent without_strays = extent_by(others);
  return by_area.diameter > kMostStretch * without_strays.diameter && without_strays.diameter > 0 ? without_strays
                                                                                                  : by_area;
}

SceneExtent scene_extent(const Mesh& mesh) {
  check(mesh);
  return scene_extent(mesh, face_areas(mesh));
}

double scene_diameter(const Mesh& mesh) {
  return scene_extent(mesh).diameter;
}

}  // namespace lumatlas
