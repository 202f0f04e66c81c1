// SPDX-License-Identifier: GPL-3.0-or-later
// A surface through points that views have seen: tetrahedra between the points are free or solid, and the surface is
// what parts them.
//
// Labatut, Pons and Keriven, "Efficient multi-view reconstruction of large-scale scenes using interest points, Delaunay
// triangulation and graph cuts", ICCV 2007; the soft votes are those of Labatut, Pons and Keriven, "Robust and
// efficient surface reconstruction from range data", 2009, sections 4.2 and 4.3.
//
// Symbols, kept in the code: alpha_vis the vote of one line of sight, sigma the noise of the points, phi and psi the
// angles between a facet and the circumspheres of the two tetrahedra beside it.
//
//   a line of sight from a point p to its view:
//     the tetrahedron that holds the view       free   with alpha_vis
//     each facet between, at distance d of p    is no surface with alpha_vis (1 - exp(-d^2 / (2 sigma^2)))
//     the tetrahedron 3 sigma behind p          solid  with alpha_vis
//   each facet                                  costs  quality (1 - min(cos phi, cos psi)), nothing on the hull
//
// A departure: a view outside of the hull makes all space free from where it sees the hull, where the papers take the
// views for points of their own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace lumatlas {

struct CutOptions {
  // Weight of a facet's shape against one line of sight, [0, 1000]. Larger: fewer points lie on the surface.
  double quality = 0.2;
  // A point that n views saw votes with alpha_vis = 1 - exp(-n^2 / (2 sure_views^2)); [0.1, 1000]
  double sure_views = 1.5;
  // sigma of points without a deviation, as a share of the median edge of the tetrahedra, [0.001, 100]. Larger: lines
  // of sight may end before or behind the surface, which is smoother then. The papers say 1; points that are thinned
  // and lie on corners of the photographs are better than that: 0.03 is a decibel above 1 on photographs left out.
  double noise = 0.03;
};

// Throws std::invalid_argument naming the field, its value and the rule.
void check(const CutOptions& options);

// Returns the faces of the surface as indices into `points`, with normals towards the free side. `views`: for each
// point, indices into `centers`, the camera centres. `deviations`: sigma of each point along its lines of sight, in the
// unit of the points, > 0; empty: options.noise sets one sigma for all points. If several points coincide, the first is
// used. Returns no face for points in one plane and for points without views. The same input gives the same faces.
// `progress` is called with the number of points counted since its last call; what it throws ends the work. Throws
// std::invalid_argument for an option out of range, an index without a centre, a list of another length than `points`,
// or a deviation that is not finite and above 0.
[[nodiscard]] std::vector<glm::uvec3> cut_surface(std::span<const glm::dvec3> points,
                                                  std::span<const std::vector<std::uint32_t>> views,
                                                  std::span<const float> deviations,
                                                  std::span<const glm::dvec3> centers, const CutOptions& options,
                                                  const std::function<void(std::size_t)>& progress);

}  // namespace lumatlas
