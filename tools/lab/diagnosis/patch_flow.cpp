// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/diagnosis/patch_flow.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr int kMostSteps = 20;          // of Gauss and Newton at one level
constexpr double kConvergedPx = 0.01;   // length of a step that is the last one
constexpr double kLeastShown = 0.6;     // share of a patch that both photographs must show
constexpr double kDarkest = 1.0 / 255;  // brightness below which its slope is bounded

// Brightness at a point, near to what the eye sees, in [0, 255], and its derivative by image position.
struct Brightness {
  double value;
  glm::dvec2 gradient;
};

Brightness brightness(const Pyramid& photograph, std::uint32_t level, const glm::dvec2& image) {
  const ColorSample sample = photograph.sample(level, image);
  const auto grey = [](const glm::dvec3& color) { return 0.25 * (color.x + 2 * color.y + color.z); };
  const double root = std::sqrt(std::max(grey(sample.color), 0.0));
  const double slope = 0.5 / std::max(root, kDarkest);
  return {255 * root, 255 * slope * glm::dvec2(grey(sample.d_x), grey(sample.d_y))};
}

// A point of the patch: its brightness in the first photograph, and where the second shows it before any move.
struct PatchPoint {
  double shown;
  glm::dvec2 carried;
};

std::vector<PatchPoint> patch_at(const Pyramid& first, std::uint32_t level, const glm::dvec2& image,
                                 const Carried& carried, int radius) {
  std::vector<PatchPoint> points;
  const double step = std::pow(2.0, level);
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      const glm::dvec2 at = image + step * glm::dvec2(x, y);
      const std::optional<glm::dvec2> to = carried(at);
      if (to) points.push_back({brightness(first, level, at).value, *to});
    }
  }
  return points;
}

// What the second photograph shows of a patch after a move, against the first: the equations of the next step, whose
// unknowns are the two of the move, a gain and an offset of the first photograph's brightness.
struct Comparison {
  Eigen::Matrix4d squares = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double count = 0, first = 0, second = 0, first_squares = 0, second_squares = 0, products = 0;

  void add(double shown, const Brightness& seen) {
    const Eigen::Vector4d row(seen.gradient.x, seen.gradient.y, -shown, -1);
    squares += row * row.transpose();
    right -= row * seen.value;
    ++count;
    first += shown;
    second += seen.value;
    first_squares += shown * shown;
    second_squares += seen.value * seen.value;
    products += shown * seen.value;
  }
  [[nodiscard]] double variance_of_first() const { return first_squares / count - std::pow(first / count, 2); }
  [[nodiscard]] double variance_of_second() const { return second_squares / count - std::pow(second / count, 2); }
  [[nodiscard]] double correlation() const {
    const double product = variance_of_first() * variance_of_second();
    return product > 0 ? (products / count - first * second / (count * count)) / std::sqrt(product) : 0;
  }
};

Comparison compare(const std::vector<PatchPoint>& points, const Pyramid& second, std::uint32_t level,
                   const glm::dvec2& move) {
  Comparison result;
  for (const PatchPoint& point : points) {
    const glm::dvec2 at = point.carried + move;
    if (second.is_valid(at)) result.add(point.shown, brightness(second, level, at));
  }
  return result;
}

// Returns the standard deviation of the move, in its least certain direction: that of what the patches differ by still,
// over the contrast that tells the move from a gain and an offset.
double deviation_of(const Comparison& last) {
  const double differing = last.variance_of_second() * (1 - std::pow(last.correlation(), 2));
  const Eigen::Matrix2d of_move = last.squares.inverse().topLeftCorner<2, 2>();
  const double half = 0.5 * of_move.trace();
  const double largest = half + std::sqrt(std::max(half * half - of_move.determinant(), 0.0));
  return std::sqrt(std::max(differing * largest, 0.0));
}

// Moves the patch at one level; false if it cannot be compared there.
bool refine_move(const std::vector<PatchPoint>& points, std::size_t whole, const Pyramid& second, std::uint32_t level,
                 double most_px, glm::dvec2& move) {
  const auto fewest = kLeastShown * static_cast<double>(whole);
  for (int step = 0; step < kMostSteps; ++step) {
    const Comparison now = compare(points, second, level, move);
    if (now.count < fewest) return false;
    const Eigen::LDLT<Eigen::Matrix4d> solved(now.squares);
    if (solved.info() != Eigen::Success || !(solved.rcond() > 1e-12)) return false;
    const Eigen::Vector4d next = solved.solve(now.right);
    const glm::dvec2 change(next[0], next[1]);
    if (!(glm::length(change) < 1e6)) return false;
    const double longest = std::pow(2.0, level);  // a pixel of the level: farther the derivatives say little
    move += glm::length(change) > longest ? longest / glm::length(change) * change : change;
    if (glm::length(move) > 2 * most_px) return false;
    if (glm::length(change) < kConvergedPx) return true;
  }
  return level > 0;  // a finer level goes on
}

constexpr Requirement flow_requires{"flow"};

}  // namespace

void check(const PatchFlowOptions& options) {
  flow_requires(options.radius_px >= 2 && options.radius_px <= 32, "radius_px", options.radius_px, "in [2, 32]");
  flow_requires(options.levels >= 1 && options.levels <= 6, "levels", options.levels, "in [1, 6]");
  flow_requires(options.most_px > 0 && std::isfinite(options.most_px), "most_px", options.most_px,
                "finite and above 0");
  flow_requires(options.least_correlation > 0 && options.least_correlation <= 1, "least_correlation",
                options.least_correlation, "in (0, 1]");
  flow_requires(options.most_deviation_px > 0 && std::isfinite(options.most_deviation_px), "most_deviation_px",
                options.most_deviation_px, "finite and above 0");
}

std::optional<glm::dvec2> patch_flow(const Pyramid& first, const Pyramid& second, const glm::dvec2& image,
                                     const Carried& carried, const PatchFlowOptions& options) {
  const auto radius = static_cast<int>(options.radius_px);
  const std::size_t whole = std::size_t{2 * options.radius_px + 1} * (2 * options.radius_px + 1);
  const std::uint32_t levels = std::min({options.levels, first.levels(), second.levels()});
  glm::dvec2 move(0);
  std::vector<PatchPoint> points;
  bool found = false;
  for (std::uint32_t level = levels; level-- > 0;) {
    points = patch_at(first, level, image, carried, radius);
    const glm::dvec2 before = move;
    found = refine_move(points, whole, second, level, options.most_px, move);
    if (!found) move = before;
  }
  if (!found || glm::length(move) > options.most_px) return std::nullopt;
  const Comparison last = compare(points, second, 0, move);
  if (last.count < kLeastShown * static_cast<double>(whole)) return std::nullopt;
  if (last.correlation() < options.least_correlation || !(deviation_of(last) <= options.most_deviation_px)) {
    return std::nullopt;
  }
  return move;
}

}  // namespace lumatlas
