// SPDX-License-Identifier: GPL-3.0-or-later
// Computes what one view adds to one cell, and the paper's measure of how well a set of views covers a cell. Erat et
// al., "Real-Time View Planning for Unstructured Lumigraph Modeling", 2019, section 3.2.
//
// Symbols, kept in the code: b a cell, F the stored views that see it, R(b) those of them that it refers to, f a view,
// gamma the largest cosine between the directions from b to f and to another view.
//
//   cov_d = min(1, (1 - gamma) / (1 - cos theta(R_max)))     directional
//   cov_p = g(d) min(1, pix_vis / pix_total)                 positional
//   cov   = lambda cov_d + (1 - lambda) cov_p                in [0, 1]
//   fcov  = sum of cov over a cell's views
//   scov  = sum of min(fcov_max, fcov) over the cells
//
// Metric::directions, the default, keeps cov_p and replaces the rest: see direction_coverage.h.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "mesh/base/id.h"
#include "mesh/camera/camera.h"
#include "mesh/cells/cells.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// The departures of the paper's measure from the print. With all of them off it is the paper to the letter.
struct CoverageDepartures {
  // The views that gamma compares a stored view with.
  enum class Comparison {
    earlier,   // those of R(b) that arrived before it: never smaller for a view more
    others,    // R(b) without itself: two neighbours are worth less together than either alone
    everyone,  // printed: R(b), itself among them, so that a referenced view has no directional coverage
  };
  Comparison comparison = Comparison::earlier;
  bool first_view = true;     // a cell without references gives cov_d = 1 (printed: 0)
  bool hemisphere = true;     // theta is bounded on the hemisphere that sees a surface (printed: the sphere)
  bool bounded_share = true;  // pix_vis / pix_total is at most 1 (printed: unbounded)
  bool references = true;     // fcov counts R(b), which alone is drawn (printed: all stored views, F)

  [[nodiscard]] static CoverageDepartures none() { return {Comparison::everyone, false, false, false, false}; }
};

struct CoverageOptions {
  enum class Metric {
    directions,  // monotone and submodular: direction_coverage.h
    paper,       // the paper's, with the departures below
  };
  Metric metric = Metric::directions;
  CoverageDepartures departures;  // for Metric::paper; bounded_share for both
  double lambda = 0.35;           // weight of direction against position, [0, 1]
  // d_max, scene units, > 0. No number fits every scene, so that 0, the default, is refused: take for instance
  // median_surface_distance(), as build_model() does. A cell with demand has its own.
  double ideal_distance = 0;
  double distance_sigma = 0;          // sigma of g, scene units, > 0; 0: half of d_max
  std::uint32_t max_references = 16;  // R_max per cell, >= 1
  double max_cell_coverage = 0;       // fcov_max of Metric::paper, > 0; 0: max_references / 2
  static constexpr std::uint32_t kMostViewsPerDirection = 8;
  // For Metric::directions: a cell counts by its share of the pictures of all offered views, and d_max is the distance
  // that they see it from. Off: cells count alike, and d_max is one for all. See cell_demand.h.
  bool demand = true;
  double demand_prior = 10;       // views that do not see a cell, added to those that do; finite, >= 0
  std::uint32_t directions = 32;  // novel directions per cell, >= 1
  double direction_width = 90;    // degrees from a novel direction beyond which a view does not serve it, (0, 180]
  // Number of best views that a novel direction counts, [1, 8]; 3: those blended.
  double reference_width = 30;  // the same where a cell's references are chosen, (0, 180]
  double reference_lambda = 1;  // weight of direction against position there, [0, 1]
  std::uint32_t views_per_direction = 3;

  [[nodiscard]] static CoverageOptions printed();
};

// Returns whether a cell's value depends on all offered views that see it.
[[nodiscard]] inline bool has_demand(const CoverageOptions& options) {
  return options.demand && options.metric == CoverageOptions::Metric::directions;
}

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const CoverageOptions& options);

// One view's part in one cell, all that coverage needs to know of it.
struct Contribution {
  glm::dvec3 direction{0.0};  // unit, from the cell's centroid to the camera
  double positional =
      0;                // cov_p at CoverageOptions::ideal_distance, in [0, 1]; with an unbounded share it can exceed 1
  double distance = 0;  // from the centroid to the camera, scene units; 0: the view asks for no cell
  double cell_share = 0;     // pix_vis / pix_total, at most 1 if that is bounded
  double picture_share = 0;  // share of the picture's pixels, in [0, 1]

  bool operator==(const Contribution&) const = default;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks. A direction of no length is one
// from nowhere in particular.
void check(const Contribution& part);

// A view's part in one of the cells that it sees.
struct CellPart {
  CellId cell;
  Contribution part;
};

// cos theta(R_max): a bound on the cosine between neighbours among R_max evenly spread directions, in [-1, 1). Throws
// std::invalid_argument unless max_references is at least 1.
[[nodiscard]] double tammes_cosine_bound(const CoverageOptions& options);

// cov_p of a view that sees so much of a cell from that distance, if d_max is `ideal_distance`, > 0. All lengths in
// scene units.
[[nodiscard]] double positional_coverage(double distance, double cell_share, double ideal_distance,
                                         const CoverageOptions& options);

// `visible_pixels` counts the camera's pixels on the cell, at the camera's resolution; finite and >= 0, `cell_size`
// finite and > 0 (std::invalid_argument).
[[nodiscard]] Contribution contribution(const Cell& cell, double cell_size, const Camera& camera, double visible_pixels,
                                        const CoverageOptions& options);

// Returns what a view sees of each cell, in the order of `seen`, which counts the camera's pixels on each. Throws as
// contribution() does, and std::invalid_argument for a cell that `cells` does not have.
[[nodiscard]] std::vector<CellPart> cell_parts(const Cells& cells, const Camera& camera,
                                               std::span<const CellPixels> seen, const CoverageOptions& options);

// cov_d from gamma, in [0, 1]; `alone`: there is no view to compare with.
[[nodiscard]] double directional_coverage(double gamma, bool alone, const CoverageOptions& options);

// A view of the set whose coverage is asked for.
struct SetMember {
  Contribution part;
  bool referenced = false;
};

// A cell's part in scov: min(fcov_max, fcov) of the stored views that see it, in order of their arrival; 0 for none.
// With all departures on it is never smaller for a referenced view more. `newcomer`: the last of them has just arrived
// and is compared with those before it alone, which makes a difference for Comparison::everyone.
[[nodiscard]] double set_coverage(std::span<const SetMember> views, bool newcomer, const CoverageOptions& options);

}  // namespace lumatlas
