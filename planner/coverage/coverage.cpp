// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/coverage.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

using Comparison = CoverageDepartures::Comparison;

double max_cell_coverage(const CoverageOptions& options) {
  return options.max_cell_coverage > 0 ? options.max_cell_coverage : options.max_references / 2.0;
}

constexpr Requirement coverage_requires{"coverage"};

// pix_total of section 3.2. There A_px is the area of one pixel at unit distance, 1 / (fx fy), and A_cell that of one
// side of a voxel, here the square of the cell size.
double total_pixels(const Cell& cell, double cell_size, double distance, const Camera& camera) {
  const double a_px = 1 / (camera.fx * camera.fy);
  const double projected = std::min(cell.area, cell_size * cell_size) / (distance * distance);
  return std::max(projected, a_px) / a_px;
}

// The largest cosine between the direction of views[index] and those of the references that it is compared with.
// `alone` if there are none.
struct Nearest {
  double gamma = -1;
  bool alone = true;
};

Nearest nearest_reference(std::span<const SetMember> views, std::size_t index, bool newcomer, Comparison comparison) {
  // A newcomer is not in R(b) yet, whatever the comparison.
  const bool is_newcomer = newcomer && index + 1 == views.size();
  Nearest nearest;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].referenced) continue;
    if (i == index && (is_newcomer || comparison != Comparison::everyone)) continue;
    if (i > index && comparison == Comparison::earlier) continue;
    if (newcomer && i + 1 == views.size() && !is_newcomer) continue;
    nearest.gamma = std::max(nearest.gamma, glm::dot(views[index].part.direction, views[i].part.direction));
    nearest.alone = false;
  }
  return nearest;
}

}  // namespace

CoverageOptions CoverageOptions::printed() {
  CoverageOptions options;
  options.metric = Metric::paper;
  options.departures = CoverageDepartures::none();
  return options;
}

void check(const CoverageOptions& options) {
  coverage_requires(options.lambda >= 0 && options.lambda <= 1, "lambda", options.lambda, "in [0, 1]");
  coverage_requires(std::isfinite(options.ideal_distance) && options.ideal_distance > 0, "ideal_distance",
                    options.ideal_distance, "finite and above 0");
  coverage_requires(std::isfinite(options.distance_sigma) && options.distance_sigma >= 0, "distance_sigma",
                    options.distance_sigma, "finite and not negative");
  coverage_requires(options.max_references >= 1, "max_references", options.max_references, "at least 1");
  coverage_requires(std::isfinite(options.max_cell_coverage) && options.max_cell_coverage >= 0, "max_cell_coverage",
                    options.max_cell_coverage, "finite and not negative");
  coverage_requires(std::isfinite(options.demand_prior) && options.demand_prior >= 0, "demand_prior",
                    options.demand_prior, "finite and not negative");
  coverage_requires(options.directions >= 1, "directions", options.directions, "at least 1");
  coverage_requires(options.direction_width > 0 && options.direction_width <= 180, "direction_width",
                    options.direction_width, "above 0 and at most 180");
  coverage_requires(options.reference_width > 0 && options.reference_width <= 180, "reference_width",
                    options.reference_width, "above 0 and at most 180");
  coverage_requires(options.reference_lambda >= 0 && options.reference_lambda <= 1, "reference_lambda",
                    options.reference_lambda, "in [0, 1]");
  coverage_requires(
      options.views_per_direction >= 1 && options.views_per_direction <= CoverageOptions::kMostViewsPerDirection,
      "views_per_direction", options.views_per_direction, "in [1, 8]");
}

void check(const Contribution& part) {
  constexpr double kRounding = 1e-4;  // error of a direction that the caller normalised, as floats
  const auto is_share = [](double share) { return std::isfinite(share) && share >= 0; };
  const double length = glm::length(part.direction);
  coverage_requires(length == 0 || std::abs(length - 1) < kRounding, "the length of a part's direction", length,
                    "1 or 0");
  coverage_requires(is_share(part.positional), "a part's positional", part.positional, "finite and not negative");
  coverage_requires(is_share(part.distance), "a part's distance", part.distance, "finite and not negative");
  coverage_requires(is_share(part.cell_share), "a part's cell_share", part.cell_share, "finite and not negative");
  coverage_requires(is_share(part.picture_share) && part.picture_share <= 1, "a part's picture_share",
                    part.picture_share, "in [0, 1]");
}

double tammes_cosine_bound(const CoverageOptions& options) {
  coverage_requires(options.max_references >= 1, "max_references", options.max_references, "at least 1");
  // The area of a cap, 2 pi (1 - cos(theta / 2)), is the sphere's (printed) or the hemisphere's divided by R_max; theta
  // is the angle between the axes of two neighbouring caps. For few caps the division would exceed the whole: -1.
  const double share = (options.departures.hemisphere ? 1.0 : 2.0) / options.max_references;
  if (share >= 1) return -1;
  return 2 * (1 - share) * (1 - share) - 1;
}

double positional_coverage(double distance, double cell_share, double ideal_distance, const CoverageOptions& options) {
  const double sigma = options.distance_sigma > 0 ? options.distance_sigma : ideal_distance / 2;
  const double off = (distance - ideal_distance) / sigma;
  return std::exp(-off * off / 2) * cell_share;
}

Contribution contribution(const Cell& cell, double cell_size, const Camera& camera, double visible_pixels,
                          const CoverageOptions& options) {
  coverage_requires(std::isfinite(visible_pixels) && visible_pixels >= 0, "visible_pixels", visible_pixels,
                    "finite and not negative");
  coverage_requires(std::isfinite(cell_size) && cell_size > 0, "cell_size", cell_size, "finite and above 0");
  const glm::dvec3 to_camera = camera.center() - cell.centroid;
  const double distance = glm::length(to_camera);
  // A camera at the centroid, or so far away that its distance is no number, sees the cell from nowhere in particular.
  if (!(distance > 0) || !std::isfinite(distance)) return {};
  double share = visible_pixels / total_pixels(cell, cell_size, distance, camera);
  if (options.departures.bounded_share) share = std::min(share, 1.0);
  const double picture = static_cast<double>(camera.width) * camera.height;
  return {to_camera / distance, positional_coverage(distance, share, options.ideal_distance, options), distance, share,
          visible_pixels / picture};
}

std::vector<CellPart> cell_parts(const Cells& cells, const Camera& camera, std::span<const CellPixels> seen,
                                 const CoverageOptions& options) {
  std::vector<CellPart> parts;
  parts.reserve(seen.size());
  for (const CellPixels& count : seen) {
    coverage_requires.is_below(count.cell, cells.cells.size(), "cell", "the number of cells");
    parts.push_back({count.cell, contribution(cells.cells[count.cell], cells.size, camera, count.pixels, options)});
  }
  return parts;
}

double directional_coverage(double gamma, bool alone, const CoverageOptions& options) {
  if (alone) return options.departures.first_view ? 1 : 0;
  return std::clamp((1 - gamma) / (1 - tammes_cosine_bound(options)), 0.0, 1.0);
}

double set_coverage(std::span<const SetMember> views, bool newcomer, const CoverageOptions& options) {
  double sum = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (options.departures.references && !views[i].referenced) continue;
    const Nearest nearest = nearest_reference(views, i, newcomer, options.departures.comparison);
    sum += options.lambda * directional_coverage(nearest.gamma, nearest.alone, options) +
           (1 - options.lambda) * views[i].part.positional;
  }
  return std::min(sum, max_cell_coverage(options));
}

}  // namespace lumatlas
