// SPDX-License-Identifier: GPL-3.0-or-later
// What one view adds to one cell, and how well a set of views covers a cell.
// Erat et al., "Real-Time View Planning for Unstructured Lumigraph Modeling", 2019, section 3.2.
//
// Symbols, kept in the code: b a cell, R(b) the views it refers to, f a view, gamma the largest cosine between the
// directions from b to f and to another view in R(b).
//
//   cov_d = min(1, (1 - gamma) / (1 - cos theta(R_max)))     directional
//   cov_p = g(d) min(1, pix_vis / pix_total)                 positional
//   cov   = lambda cov_d + (1 - lambda) cov_p                in [0, 1]
//   fcov  = min(fcov_max, sum of cov over a cell's views)
//
// Departures from the print: an empty R(b) gives cov_d = 1 (printed: 0); theta is bounded on the hemisphere that can
// see a surface (printed: the sphere); a stored view is compared with the views that arrived before it (printed: with
// all of R(b), itself among them, so that its cov_d is always 0); pix_vis / pix_total is at most 1. Leaving only the
// view itself out of the comparison would make two neighbours worth less than either alone; measured, it costs 0.65 dB
// on a photo scene (docs/measurements.md). CoverageOptions::printed() is the paper to the letter.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "mesh/camera.h"
#include "mesh/cells.h"

namespace lumatlas {

struct CoverageOptions {
  enum class Metric {
    departures,  // as described above
    printed,
  };
  Metric metric = Metric::departures;
  double lambda = 0.5;                // weight of direction against position, [0, 1]
  double ideal_distance = 0;          // d_max, scene units, > 0; see median_surface_distance()
  double distance_sigma = 0;          // sigma of g, scene units, > 0; 0: half of ideal_distance
  std::uint32_t max_references = 16;  // R_max per cell, >= 1
  double max_cell_coverage = 0;       // fcov_max, > 0; 0: max_references / 2

  [[nodiscard]] static CoverageOptions printed();
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const CoverageOptions& options);

// One view's part in one cell, all that coverage needs to know of it.
struct Contribution {
  glm::dvec3 direction{0.0};  // unit, from the cell's centroid to the camera
  double positional = 0;      // cov_p, in [0, 1]; printed, it can exceed 1
};

// cos theta(R_max): a bound on the cosine between neighbours among R_max evenly spread directions, in [-1, 1).
[[nodiscard]] double tammes_cosine_bound(const CoverageOptions& options);

// `visible_pixels` counts the camera's pixels on the cell, at the camera's resolution.
[[nodiscard]] Contribution contribution(const Cell& cell, double cell_size, const Camera& camera, double visible_pixels,
                                        const CoverageOptions& options);

// cov_d from gamma, in [0, 1]; `alone`: there is no view to compare with.
[[nodiscard]] double directional_coverage(double gamma, bool alone, const CoverageOptions& options);

// cov(f, b) in [0, 1] (printed: no upper bound) against `others`, which do not hold f.
[[nodiscard]] double coverage(const Contribution& view, std::span<const Contribution> others,
                              const CoverageOptions& options);

// fcov of a set of views in order of their arrival, in [0, max_cell_coverage]; 0 for none. Never smaller for a view
// more.
[[nodiscard]] double set_coverage(std::span<const Contribution> views, const CoverageOptions& options);

// fcov(R(b) + f): the set with the last of `views` new to it. Differs from set_coverage() only for the printed metric,
// in which a view has directional coverage when it arrives and none once it is stored.
[[nodiscard]] double set_coverage_with_newcomer(std::span<const Contribution> views, const CoverageOptions& options);

}  // namespace lumatlas
