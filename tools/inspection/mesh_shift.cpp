// SPDX-License-Identifier: GPL-3.0-or-later
// Y. Chen and G. Medioni, "Object Modeling by Registration of Multiple Range Images", 1991; the largest distances left
// out as in D. Chetverikov et al., "The Trimmed Iterative Closest Point Algorithm", 2002.
#include "tools/inspection/mesh_shift.h"

#include <CGAL/Orthogonal_k_neighbor_search.h>
#include <CGAL/Search_traits_3.h>
#include <CGAL/Search_traits_adapter.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/property_map.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "mesh/base/median.h"
#include "mesh/scene_extent.h"
#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

// ---- Samples of the mesh, and the nearest of them --------------------------------------------------------------

struct SurfaceSample {
  glm::dvec3 position;
  glm::dvec3 normal;  // unit
};

// Evenly over the area: each face has its share of samples, along a line from a corner through it.
std::vector<SurfaceSample> sampled_surface(const Mesh& mesh) {
  constexpr double kSamples = 20'000;
  std::vector<glm::dvec3> normals;  // with twice the face's area as length
  double area = 0;
  for (const glm::uvec3& face : mesh.faces) {
    const glm::dvec3 a(mesh.positions[face.x]), b(mesh.positions[face.y]), c(mesh.positions[face.z]);
    normals.push_back(glm::cross(b - a, c - a));
    area += glm::length(normals.back());
  }
  std::vector<SurfaceSample> samples;
  double owed = 0;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const double length = glm::length(normals[i]);
    if (!(length > 0)) continue;
    const glm::uvec3& face = mesh.faces[i];
    const glm::dvec3 a(mesh.positions[face.x]), b(mesh.positions[face.y]), c(mesh.positions[face.z]);
    owed += kSamples * length / area;
    const auto count = static_cast<std::size_t>(owed);
    owed -= static_cast<double>(count);
    for (std::size_t n = 0; n < count; ++n) {
      // The sequence of M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018, folded.
      const auto number = static_cast<double>(n + 1);
      double u = std::fmod(0.5 + 0.7548776662466927 * number, 1), v = std::fmod(0.5 + 0.5698402909980532 * number, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      samples.push_back({a + u * (b - a) + v * (c - a), normals[i] / length});
    }
  }
  return samples;
}

using Kernel = CGAL::Simple_cartesian<double>;
using NumberedPoint = std::pair<Kernel::Point_3, std::size_t>;
using SearchTraits = CGAL::Search_traits_adapter<NumberedPoint, CGAL::First_of_pair_property_map<NumberedPoint>,
                                                 CGAL::Search_traits_3<Kernel>>;
using NearestSearch = CGAL::Orthogonal_k_neighbor_search<SearchTraits>;

class SampleTree {
 public:
  explicit SampleTree(std::vector<SurfaceSample> samples) : samples_(std::move(samples)) {
    std::vector<NumberedPoint> points;
    points.reserve(samples_.size());
    for (const SurfaceSample& sample : samples_) {
      const glm::dvec3& p = sample.position;
      points.emplace_back(Kernel::Point_3(p.x, p.y, p.z), points.size());
    }
    tree_.insert(points.begin(), points.end());
    tree_.build();
  }

  // Null if none is within `reach`.
  [[nodiscard]] const SurfaceSample* nearest(const glm::dvec3& point, double reach) const {
    const NearestSearch search(tree_, {point.x, point.y, point.z}, 1);
    const auto& [found, squared_distance] = *search.begin();
    return squared_distance < reach * reach ? &samples_[found.second] : nullptr;
  }

 private:
  std::vector<SurfaceSample> samples_;
  NearestSearch::Tree tree_;
};

// ---- Fitting ---------------------------------------------------------------------------------------------------

// A point against the plane of the sample that is nearest to it.
struct PlaneDistance {
  glm::dvec3 normal;
  double along = 0;  // signed, along the normal
  double to_sample = 0;
};

struct ShiftFit {
  glm::dvec3 shift{0};                                    // the mesh's
  double cost = std::numeric_limits<double>::infinity();  // mean distance to planes, those of strays cut off
  double distance = 0;                                    // that half of the points have to their planes at most
  double to_samples = 0;                                  // the same to the samples
};

// Returns distances to the samples' planes. A point further than `reach` from all samples has that distance and no
// plane.
std::vector<PlaneDistance> plane_distances(const SampleTree& tree, const std::vector<glm::dvec3>& points,
                                           const glm::dvec3& shift, double reach) {
  std::vector<PlaneDistance> distances;
  distances.reserve(points.size());
  for (const glm::dvec3& point : points) {
    const glm::dvec3 moved = point - shift;
    if (const SurfaceSample* const sample = tree.nearest(moved, reach)) {
      const glm::dvec3 from_sample = moved - sample->position;
      distances.push_back({sample->normal, glm::dot(from_sample, sample->normal), glm::length(from_sample)});
    } else {
      distances.push_back({glm::dvec3(0), reach, reach});
    }
  }
  std::sort(distances.begin(), distances.end(),
            [](const PlaneDistance& a, const PlaneDistance& b) { return a.to_sample < b.to_sample; });
  return distances;
}

// The shift that brings the nearest nine tenths of the points onto their planes, those that are up to `usual` away
// before others (Geman and McClure's weights); a direction that no plane says anything of stays.
glm::dvec3 step_to_planes(const std::vector<PlaneDistance>& distances, double usual) {
  constexpr double kDamping = 1e-3;  // share of the mean of the diagonal
  glm::dmat3 a(0.0);
  glm::dvec3 b(0);
  double sum = 0;
  for (std::size_t i = 0; i < distances.size() - distances.size() / 10; ++i) {
    const auto& [normal, along, to_sample] = distances[i];
    const double root = usual * usual / (usual * usual + along * along);
    const double weight = root * root;
    a += weight * glm::outerProduct(normal, normal);
    b += weight * along * normal;
    sum += weight;
  }
  const double damping = kDamping * sum / 3;
  for (int i = 0; i < 3; ++i) a[i][i] += damping;
  return glm::inverse(a) * b;
}

// `stray`: how far a point is at least that does not belong to the mesh.
ShiftFit judged_fit(const std::vector<PlaneDistance>& distances, const glm::dvec3& shift, double stray) {
  std::vector<double> along;
  double cost = 0;
  for (const PlaneDistance& distance : distances) {
    along.push_back(std::abs(distance.along));
    cost += distance.to_sample <= stray ? along.back() : stray;
  }
  return {shift, cost / static_cast<double>(distances.size()), upper_median(along),
          distances[distances.size() / 2].to_sample};
}

// From the shift `begin` on. Distances are taken for usual that are up to `usual`, less at every step.
ShiftFit fitted(const SampleTree& tree, const std::vector<glm::dvec3>& points, const glm::dvec3& begin, double diameter,
                double usual, int steps) {
  constexpr double kShrinking = 0.7;
  constexpr double kLeastUsual = 1e-3, kStray = 0.02, kReach = 0.2;  // shares of the diameter
  glm::dvec3 shift = begin;
  for (int step = 0;; ++step) {
    throw_if_interrupted();
    const std::vector<PlaneDistance> distances = plane_distances(tree, points, shift, kReach * diameter);
    if (step == steps) return judged_fit(distances, shift, kStray * diameter);
    shift += step_to_planes(distances, std::max(usual, kLeastUsual) * diameter);
    usual *= kShrinking;
  }
}

// The middle of the box of all but the outermost twentieth on each side.
glm::dvec3 middle_of_bulk(const std::vector<glm::dvec3>& positions) {
  glm::dvec3 middle(0);
  std::vector<double> values(positions.size());
  const std::size_t outermost = positions.size() / 20;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < positions.size(); ++i) values[i] = positions[i][axis];
    std::sort(values.begin(), values.end());
    middle[axis] = (values[outermost] + values[values.size() - 1 - outermost]) / 2;
  }
  return middle;
}

std::vector<glm::dvec3> every_nth(std::span<const glm::dvec3> points, std::size_t most) {
  const std::size_t stride = (points.size() + most - 1) / most;
  std::vector<glm::dvec3> some;
  for (std::size_t i = 0; i < points.size(); i += stride) some.push_back(points[i]);
  return some;
}

// Begins in a grid around the middle, because points may cover another part of the scene than the mesh, and goes on
// with the best of these and more points.
ShiftFit best_fit(const SampleTree& tree, std::span<const glm::dvec3> points, const glm::dvec3& middle,
                  double diameter) {
  constexpr int kGrid = 2, kSteps = 8, kMoreSteps = 15;
  constexpr double kSpacing = 1.0 / 20, kUsual = 0.05, kUsualLater = 0.01;  // shares of the diameter
  constexpr std::size_t kBest = 8, kFew = 200, kMore = 1000, kMost = 5000;  // fits and points
  std::vector<ShiftFit> fits;
  const std::vector<glm::dvec3> few = every_nth(points, kFew), more = every_nth(points, kMore);
  for (int x = -kGrid; x <= kGrid; ++x) {
    for (int y = -kGrid; y <= kGrid; ++y) {
      for (int z = -kGrid; z <= kGrid; ++z) {
        const glm::dvec3 begin = middle + kSpacing * diameter * glm::dvec3(x, y, z);
        fits.push_back(fitted(tree, few, begin, diameter, kUsual, kSteps));
      }
    }
  }
  const auto better = [](const ShiftFit& a, const ShiftFit& b) { return a.cost < b.cost; };
  std::sort(fits.begin(), fits.end(), better);
  fits.resize(kBest);
  for (ShiftFit& fit : fits) fit = fitted(tree, more, fit.shift, diameter, kUsualLater, kMoreSteps);
  const ShiftFit& best = *std::min_element(fits.begin(), fits.end(), better);
  return fitted(tree, every_nth(points, kMost), best.shift, diameter, kUsualLater, kMoreSteps);
}

// To multiples of 10^exponent.
glm::dvec3 rounded_to(const glm::dvec3& shift, int exponent) {
  const double power = std::pow(10, std::abs(exponent));
  return exponent >= 0 ? power * glm::round(shift / power) : glm::round(shift * power) / power;
}

// The shift in units as large as `tolerance` allows; they must be this much larger, so that it is no chance.
glm::dvec3 rounded_shift(const glm::dvec3& shift, double tolerance) {
  constexpr int kLargestUnit = 3;  // 1000
  constexpr double kNoChance = 20;
  const int within_tolerance = static_cast<int>(std::floor(std::log10(tolerance))) - 1;
  for (int exponent = kLargestUnit; std::pow(10, exponent) > kNoChance * tolerance; --exponent) {
    const glm::dvec3 whole = rounded_to(shift, exponent);
    const glm::dvec3 off = glm::abs(whole - shift);
    if (std::max({off.x, off.y, off.z}) <= tolerance) return whole;
  }
  return rounded_to(shift, within_tolerance);
}

}  // namespace

std::optional<glm::dvec3> estimated_mesh_shift(const Mesh& mesh, std::span<const glm::dvec3> points) {
  constexpr std::size_t kFewestPoints = 50, kForMiddle = 5000;
  constexpr double kOnMesh = 0.02, kLeastTolerance = 1e-4;  // shares of the diameter
  if (points.size() < kFewestPoints) return std::nullopt;
  std::vector<SurfaceSample> samples = sampled_surface(mesh);
  if (samples.empty()) return std::nullopt;
  const double diameter = scene_diameter(mesh);
  std::vector<glm::dvec3> positions;
  positions.reserve(samples.size());
  for (const SurfaceSample& sample : samples) positions.push_back(sample.position);
  const glm::dvec3 middle = middle_of_bulk(every_nth(points, kForMiddle)) - middle_of_bulk(positions);
  const SampleTree tree(std::move(samples));
  const ShiftFit fit = best_fit(tree, points, middle, diameter);
  if (!(fit.to_samples <= kOnMesh * diameter)) return std::nullopt;
  return rounded_shift(fit.shift, std::max(fit.distance, kLeastTolerance * diameter));
}

}  // namespace lumatlas
