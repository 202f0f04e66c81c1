// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/paths/spline.h"

#include <algorithm>
#include <glm/glm.hpp>
#include <stdexcept>
#include <string>

namespace lumatlas {

using glm::dvec3;

Spline::Spline(std::vector<dvec3> points, Ends ends) : points_(std::move(points)), ends_(ends) {
  const std::size_t least = ends == Ends::closed ? 4 : 2;
  if (points_.size() < least) {
    throw std::invalid_argument("spline: has " + std::to_string(points_.size()) + " points, must have at least " +
                                std::to_string(least));
  }
  if (ends == Ends::open) {
    // One more point at each end, as far beyond it as its neighbour is before: the curve then reaches the end itself.
    points_.insert(points_.begin(), 2.0 * points_[0] - points_[1]);
    points_.push_back(2.0 * points_.back() - points_[points_.size() - 2]);
  }
  segments_ = ends == Ends::closed ? points_.size() : points_.size() - 3;
}

Spline::Segment Spline::segment_at(double t) const {
  const std::size_t first = std::min(static_cast<std::size_t>(t), segments_ - 1);
  return {first, t - static_cast<double>(first)};
}

dvec3 Spline::at(double t) const {
  const auto [i, f] = segment_at(t);
  const double g = 1 - f;
  return (g * g * g * point(i) + (3 * f * f * f - 6 * f * f + 4) * point(i + 1) +
          (3 * g * g * g - 6 * g * g + 4) * point(i + 2) + f * f * f * point(i + 3)) /
         6.0;
}

dvec3 Spline::derivative(double t) const {
  const auto [i, f] = segment_at(t);
  const double g = 1 - f;
  return (-g * g * point(i) + (3 * f * f - 4 * f) * point(i + 1) - (3 * g * g - 4 * g) * point(i + 2) +
          f * f * point(i + 3)) /
         2.0;
}

std::vector<double> Spline::equal_steps(std::size_t count) const {
  constexpr std::size_t kFine = 256;  // pieces per segment: chords within 1e-5 of the arc
  const std::size_t pieces = kFine * segments_;
  std::vector<double> distance{0};
  for (std::size_t i = 1; i <= pieces; ++i) {
    distance.push_back(distance.back() +
                       glm::distance(at(static_cast<double>(i - 1) / kFine), at(static_cast<double>(i) / kFine)));
  }
  const std::size_t steps = ends_ == Ends::closed ? count : std::max<std::size_t>(count, 2) - 1;
  std::vector<double> parameters;
  for (std::size_t i = 0; i < count; ++i) {
    const double target = distance.back() * static_cast<double>(i) / static_cast<double>(steps);
    const auto after = std::upper_bound(distance.begin() + 1, distance.end() - 1, target);
    const auto piece = static_cast<std::size_t>(after - distance.begin()) - 1;
    const double extent = distance[piece + 1] - distance[piece];
    const double rest = extent > 0 ? (target - distance[piece]) / extent : 0;
    parameters.push_back((static_cast<double>(piece) + rest) / kFine);
  }
  return parameters;
}

}  // namespace lumatlas
