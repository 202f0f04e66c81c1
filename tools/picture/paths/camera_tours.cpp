// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/paths/camera_tours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <stdexcept>
#include <string>

#include "mesh/base/median.h"
#include "mesh/upright.h"
#include "tools/picture/paths/spline.h"

namespace lumatlas {

namespace {

using glm::dmat3;
using glm::dvec2;
using glm::dvec3;

void require_views(std::span<const Camera> stored) {
  if (stored.empty()) throw std::invalid_argument("tour: there is no stored view, must be at least one");
}

template <typename Of>
double median_of(std::span<const Camera> stored, const Of& of) {
  std::vector<double> values;
  for (const Camera& camera : stored) values.push_back(of(camera));
  return percentile(std::move(values), 0.5);
}

// Any direction at right angles to a unit vector.
dvec3 across(const dvec3& up) {
  return glm::normalize(glm::cross(up, std::abs(up.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
}

// The point nearest to all lines of sight, pulled a little towards what lies `depth` ahead of the cameras: lines that
// are parallel meet nowhere.
dvec3 looked_at(std::span<const Camera> stored, double depth) {
  constexpr double kPull = 0.05;
  dmat3 sum(0.0);
  dvec3 moment(0);
  for (const Camera& camera : stored) {
    const dvec3 direction = camera.viewing_direction();
    const dmat3 off_line = dmat3(1 + kPull) - glm::outerProduct(direction, direction);
    const dvec3 ahead = camera.center() + depth * direction;
    sum += off_line;
    moment += off_line * ahead;  // any point of the line does
  }
  return glm::inverse(sum) * moment;
}

// The ground under a mesh: a rectangle at right angles to `up`, along the surface's main directions.
struct Ground {
  dvec3 along, aside;  // unit
  dvec2 low, high;     // in units of them
};

struct WeightedPoint {
  dvec3 at;
  double area;
};

std::vector<WeightedPoint> face_points(const Mesh& mesh) {
  std::vector<WeightedPoint> points;
  points.reserve(mesh.faces.size());
  for (const glm::uvec3& face : mesh.faces) {
    const dvec3 a(mesh.positions[face.x]);
    const dvec3 b(mesh.positions[face.y]);
    const dvec3 c(mesh.positions[face.z]);
    points.push_back({(a + b + c) / 3.0, glm::length(glm::cross(b - a, c - a)) / 2});
  }
  return points;
}

// The coordinate that this share of the area is below.
double coordinate_above(const std::vector<WeightedPoint>& points, const dvec3& axis, double share) {
  std::vector<std::pair<double, double>> sorted;
  double total = 0;
  for (const WeightedPoint& point : points) {
    sorted.emplace_back(glm::dot(point.at, axis), point.area);
    total += point.area;
  }
  std::sort(sorted.begin(), sorted.end());
  double below = 0;
  for (const auto& [at, area] : sorted) {
    below += area;
    if (below >= share * total) return at;
  }
  return sorted.back().first;
}

// The main axis of the surface's spread at right angles to `up`.
dvec3 main_axis(const std::vector<WeightedPoint>& points, const dvec3& up) {
  const dvec3 u = across(up);
  const dvec3 v = glm::cross(up, u);
  double total = 0;
  dvec2 mean(0);
  for (const WeightedPoint& point : points) {
    mean += point.area * dvec2(glm::dot(point.at, u), glm::dot(point.at, v));
    total += point.area;
  }
  if (!(total > 0)) return u;
  mean /= total;
  double uu = 0;
  double uv = 0;
  double vv = 0;
  for (const WeightedPoint& point : points) {
    const dvec2 apart = dvec2(glm::dot(point.at, u), glm::dot(point.at, v)) - mean;
    uu += point.area * apart.x * apart.x;
    uv += point.area * apart.x * apart.y;
    vv += point.area * apart.y * apart.y;
  }
  const double angle = std::atan2(2 * uv, uu - vv) / 2;
  return std::cos(angle) * u + std::sin(angle) * v;
}

Ground ground_under(const Mesh& mesh, const dvec3& up) {
  constexpr double kOutermost = 0.01;  // share of the area, on each side
  const std::vector<WeightedPoint> points = face_points(mesh);
  if (points.empty()) throw std::invalid_argument("tour: the mesh has no faces, must have at least one");
  Ground ground;
  ground.along = main_axis(points, up);
  ground.aside = glm::cross(up, ground.along);
  ground.low = {coordinate_above(points, ground.along, kOutermost), coordinate_above(points, ground.aside, kOutermost)};
  ground.high = {coordinate_above(points, ground.along, 1 - kOutermost),
                 coordinate_above(points, ground.aside, 1 - kOutermost)};
  return ground;
}

// The points of the square whose curve begins at `corner` and ends at the far end of `a`: four of half the side, turned
// so that each begins beside where the last one ends.
void add_cells(std::vector<glm::ivec2>& cells, glm::ivec2 corner, glm::ivec2 a, glm::ivec2 b, std::uint32_t order) {
  if (order == 0) {
    cells.push_back(corner);
    return;
  }
  const int half = 1 << (order - 1);
  add_cells(cells, corner, b, a, order - 1);
  add_cells(cells, corner + half * b, a, b, order - 1);
  add_cells(cells, corner + half * (a + b), a, b, order - 1);
  add_cells(cells, corner + (2 * half - 1) * a + (half - 1) * b, -b, -a, order - 1);
}

}  // namespace

std::vector<Vantage> orbit(std::span<const Camera> stored, double depth, std::size_t frames, double fov_deg) {
  std::vector<double> turns;
  for (std::size_t i = 0; i < frames; ++i) turns.push_back(static_cast<double>(i) / static_cast<double>(frames));
  return orbit_at(stored, depth, turns, fov_deg);
}

std::vector<Vantage> orbit_at(std::span<const Camera> stored, double depth, std::span<const double> turns,
                              double fov_deg) {
  require_views(stored);
  const dvec3 up = upward(stored);
  const dvec3 target = looked_at(stored, depth);
  const auto height = [&](const Camera& camera) { return glm::dot(camera.center() - target, up); };
  const auto outward = [&](const Camera& camera) { return camera.center() - target - height(camera) * up; };
  double radius = median_of(stored, [&](const Camera& camera) { return glm::length(outward(camera)); });
  if (!(radius > 1e-3 * depth)) radius = depth;
  const double above = median_of(stored, height);
  const dvec3 first = outward(stored.front());
  const dvec3 u = glm::length(first) > 1e-6 * depth ? glm::normalize(first) : across(up);
  const dvec3 v = glm::cross(up, u);
  std::vector<Vantage> vantages;
  for (const double turn : turns) {
    const double angle = 2 * std::numbers::pi * turn;
    const dvec3 position = target + above * up + radius * (std::cos(angle) * u + std::sin(angle) * v);
    vantages.push_back({position, look_at(position, target, up), fov_deg});
  }
  return vantages;
}

std::vector<Vantage> walk(std::span<const Camera> stored, double depth, std::size_t frames, double fov_deg) {
  require_views(stored);
  constexpr double kLeastStep = 1e-3;  // cameras at one place still follow one another
  std::vector<KeyFrame> keys;
  for (const Camera& camera : stored) {
    KeyFrame key;
    key.vantage = {camera.center(), glm::normalize(glm::quat_cast(camera.cam_from_world_rotation)), fov_deg};
    if (!keys.empty()) {
      const Vantage& last = keys.back().vantage;
      const double moved = glm::distance(last.position, key.vantage.position) / depth;
      const double cosine = std::abs(glm::dot(last.cam_from_world, key.vantage.cam_from_world));
      key.time = keys.back().time + std::max(kLeastStep, moved + 2 * std::acos(std::min(1.0, cosine)));
    }
    keys.push_back(key);
  }
  return CameraPath(std::move(keys)).evenly(frames);
}

std::vector<glm::ivec2> hilbert_cells(std::uint32_t order) {
  if (order > kMostHilbertOrder) {
    throw std::invalid_argument("tour: the Hilbert curve's order is " + std::to_string(order) + ", must be in [0, 8]");
  }
  std::vector<glm::ivec2> cells;
  add_cells(cells, {0, 0}, {1, 0}, {0, 1}, order);
  return cells;
}

std::vector<Vantage> hilbert_flight(const Mesh& mesh, std::span<const Camera> stored, std::uint32_t order,
                                    std::size_t frames, double fov_deg) {
  require_views(stored);
  const dvec3 up = upward(stored);
  if (order < 1) throw std::invalid_argument("tour: the Hilbert curve's order is 0, must be in [1, 8]");
  const Ground ground = ground_under(mesh, up);
  const double height = median_of(stored, [&](const Camera& camera) { return glm::dot(camera.center(), up); });
  const double pitch = median_of(stored, [&](const Camera& camera) {
    return std::asin(std::clamp(glm::dot(camera.viewing_direction(), up), -1.0, 1.0));
  });
  const double side = 1u << order;
  std::vector<dvec3> points;
  for (const glm::ivec2& cell : hilbert_cells(order)) {
    const dvec2 at = glm::mix(ground.low, ground.high, (dvec2(cell) + 0.5) / side);
    points.push_back(at.x * ground.along + at.y * ground.aside + height * up);
  }
  const Spline curve(points, Spline::Ends::open);
  std::vector<Vantage> vantages;
  for (const double t : curve.equal_steps(frames)) {
    const dvec3 speed = curve.derivative(t);
    const dvec3 ahead = glm::length(speed) > 0 ? glm::normalize(speed) : ground.along;
    const dvec3 position = curve.at(t);
    vantages.push_back(
        {position, look_at(position, position + std::cos(pitch) * ahead + std::sin(pitch) * up, up), fov_deg});
  }
  return vantages;
}

}  // namespace lumatlas
