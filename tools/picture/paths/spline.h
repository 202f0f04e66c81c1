// SPDX-License-Identifier: GPL-3.0-or-later
// Smooth curves through the neighbourhood of points: uniform cubic B-splines.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

namespace lumatlas {

// Twice continuously differentiable, and within the hull of any four points in a row. A closed one returns to where it
// began; an open one begins at the first point and ends at the last.
class Spline {
 public:
  enum class Ends { open, closed };

  // Throws std::invalid_argument for fewer than four points of a closed one, or fewer than two of an open one.
  Spline(std::vector<glm::dvec3> points, Ends ends);

  [[nodiscard]] double length() const {
    return static_cast<double>(segments_);
  }  // in the parameter's range [0, length)
  [[nodiscard]] glm::dvec3 at(double t) const;
  [[nodiscard]] glm::dvec3 derivative(double t) const;

  // `count` parameters, ascending, whose points are at equal distances along the curve, from its beginning; of an open
  // one to its end, of a closed one to a step before it. Distances are exact to 1e-5 of the length.
  [[nodiscard]] std::vector<double> equal_steps(std::size_t count) const;

 private:
  struct Segment {
    std::size_t first;
    double f;  // within it, [0, 1]
  };
  [[nodiscard]] Segment segment_at(double t) const;
  [[nodiscard]] const glm::dvec3& point(std::size_t i) const { return points_[i % points_.size()]; }

  std::vector<glm::dvec3> points_;
  Ends ends_;
  std::size_t segments_;
};

}  // namespace lumatlas
