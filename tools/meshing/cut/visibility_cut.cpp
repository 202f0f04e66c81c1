// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/cut/visibility_cut.h"

// Clang's analyzer takes the way in which CGAL frees these numbers for a mistake.
#ifdef __clang_analyzer__
#define CGAL_DO_NOT_USE_MPZF
#endif
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>

#include "mesh/base/median.h"
#include "mesh/base/number_text.h"
#include "tools/meshing/cut/minimum_cut.h"

namespace lumatlas {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Vector = Kernel::Vector_3;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;  // the index of its point
using CellBase =
    CGAL::Triangulation_cell_base_with_info_3<std::uint32_t, Kernel, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;
using Cell = Delaunay::Cell_handle;

// Votes are whole numbers, so that their sum does not depend on the order, and the flow is exact.
constexpr double kOneVote = 1 << 16;

Capacity weight_of(double votes) {
  return std::llround(kOneVote * votes);
}

Point cgal(const glm::dvec3& p) {
  return {p.x, p.y, p.z};
}

// The votes of all lines of sight. Cells are counted as in cell->info(); facet 4 c + i is that of cell c opposite its
// vertex i, seen from c.
struct Votes {
  std::vector<Capacity> free, solid;  // a cell
  std::vector<Capacity> no_surface;   // a facet whose cell is free while its neighbour is solid
};

Delaunay triangulation_of(std::span<const glm::dvec3> points) {
  std::vector<std::pair<Point, std::uint32_t>> numbered;
  numbered.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) numbered.emplace_back(cgal(points[i]), static_cast<std::uint32_t>(i));
  Delaunay result;
  result.insert(numbered.begin(), numbered.end());
  if (result.dimension() < 3) return result;
  std::uint32_t count = 0;
  for (const Cell cell : result.all_cell_handles()) cell->info() = count++;
  return result;
}

double median_edge(const Delaunay& tetrahedra) {
  std::vector<double> lengths;
  for (const auto& edge : tetrahedra.finite_edges())
    lengths.push_back(std::sqrt(tetrahedra.segment(edge).squared_length()));
  return lengths.empty() ? 0 : upper_median(lengths);
}

class VoteCounter {
 public:
  explicit VoteCounter(const Delaunay& tetrahedra)
      : tetrahedra_(tetrahedra),
        hull_(hull_of(tetrahedra)),
        votes_{std::vector<Capacity>(tetrahedra.number_of_cells()), std::vector<Capacity>(tetrahedra.number_of_cells()),
               std::vector<Capacity>(4 * tetrahedra.number_of_cells())} {}

  void count(Delaunay::Vertex_handle p, const Point& view, double alpha_vis, double sigma) {
    sigma_ = sigma;
    const Vector sight = view - p->point();
    const double distance = std::sqrt(sight.squared_length());
    if (!(distance > 0)) return;
    const Capacity vote = weight_of(alpha_vis);
    votes_.free[towards(p, view, alpha_vis)->info()] += vote;
    const Point behind = p->point() - sight * (3 * sigma_ / distance);
    votes_.solid[last_cell(p, behind)->info()] += vote;
  }

  // A view outside of the hull is in all the infinite cells whose facets it sees from there.
  void count_outside(const Point& view) {
    for (const HullFacet& facet : hull_) {
      if (CGAL::orientation(facet.corners[0], facet.corners[1], facet.corners[2], view) == facet.outside) {
        votes_.free[facet.cell] += weight_of(1);
      }
    }
  }

  [[nodiscard]] Votes take() { return std::move(votes_); }

 private:
  // A facet of the hull, and the infinite cell beyond it.
  struct HullFacet {
    std::array<Point, 3> corners;
    CGAL::Orientation outside;  // orientation of the corners and a point beyond the facet
    std::uint32_t cell;
  };

  // Views outside are many, and the hull has few of all the cells.
  static std::vector<HullFacet> hull_of(const Delaunay& tetrahedra) {
    std::vector<Cell> infinite_cells;
    tetrahedra.incident_cells(tetrahedra.infinite_vertex(), std::back_inserter(infinite_cells));
    std::vector<HullFacet> hull;
    hull.reserve(infinite_cells.size());
    for (const Cell cell : infinite_cells) {
      const int infinite = cell->index(tetrahedra.infinite_vertex());
      const Cell inner = cell->neighbor(infinite);
      const Point& apex = inner->vertex(inner->index(cell))->point();
      const auto corner = [&](int i) { return cell->vertex((infinite + i) & 3)->point(); };
      const CGAL::Orientation inside = CGAL::orientation(corner(1), corner(2), corner(3), apex);
      // Cells of the hull that have no volume are seen by no view.
      if (inside != CGAL::COPLANAR) hull.push_back({{corner(1), corner(2), corner(3)}, -inside, cell->info()});
    }
    return hull;
  }

  // The cell that holds the view; on the way there the facets get their votes.
  Cell towards(Delaunay::Vertex_handle p, const Point& view, double alpha_vis) {
    Delaunay::Segment_cell_iterator cell(&tetrahedra_, p, view);
    Cell last = Cell(cell);
    for (++cell; cell != tetrahedra_.segment_traverser_cells_end(); ++cell) {
      const Cell next = Cell(cell);
      add_no_surface(next, last, p->point(), view, alpha_vis);
      last = next;
    }
    return last;
  }

  // If the line crosses an edge or a vertex, the two cells share no facet, and nothing is added.
  void add_no_surface(Cell nearer_to_view, Cell nearer_to_point, const Point& p, const Point& view, double alpha_vis) {
    int facet = 0;
    if (!nearer_to_view->has_neighbor(nearer_to_point, facet)) return;
    const double d2 = squared_distance_to_facet(nearer_to_view, facet, p, view);
    const double soft = alpha_vis * (1 - std::exp(-d2 / (2 * sigma_ * sigma_)));
    votes_.no_surface[4 * std::size_t{nearer_to_view->info()} + static_cast<std::size_t>(facet)] += weight_of(soft);
  }

  // From p along the line of sight, squared; nothing where the facet has no plane of its own.
  [[nodiscard]] double squared_distance_to_facet(Cell cell, int facet, const Point& p, const Point& view) const {
    const auto at = [&](int corner) { return cell->vertex((facet + corner) & 3)->point(); };
    const Vector normal = CGAL::cross_product(at(2) - at(1), at(3) - at(1));
    const Vector sight = view - p;
    const double slope = normal * sight;
    const double t = slope != 0 ? std::clamp(normal * (at(1) - p) / slope, 0.0, 1.0) : 0;
    return t * t * sight.squared_length();
  }

  [[nodiscard]] Cell last_cell(Delaunay::Vertex_handle p, const Point& target) const {
    Delaunay::Segment_cell_iterator cell(&tetrahedra_, p, target);
    Cell last = Cell(cell);
    for (++cell; cell != tetrahedra_.segment_traverser_cells_end(); ++cell) last = Cell(cell);
    return last;
  }

  const Delaunay& tetrahedra_;
  std::vector<HullFacet> hull_;
  double sigma_ = 0;  // the counted point's
  Votes votes_;
};

// 1 - min(cos phi, cos psi), in [0, 2]; 0 at the hull, where there is no second circumsphere.
double shape_cost(const Delaunay& tetrahedra, Cell cell, int facet) {
  const Cell neighbor = cell->neighbor(facet);
  if (tetrahedra.is_infinite(cell) || tetrahedra.is_infinite(neighbor)) return 0;
  const auto corner = [&](int i) { return cell->vertex(Delaunay::vertex_triple_index(facet, i))->point(); };
  const Vector normal = CGAL::cross_product(corner(1) - corner(0), corner(2) - corner(0));
  const auto cosine = [&](const Point& circumcenter) {
    const Vector radius = circumcenter - corner(0);
    const double scale = std::sqrt(normal.squared_length() * radius.squared_length());
    return scale > 0 ? std::clamp(std::abs(normal * radius) / scale, 0.0, 1.0) : 0;
  };
  return 1 - std::min(cosine(tetrahedra.dual(cell)), cosine(tetrahedra.dual(neighbor)));
}

// Nodes are the cells; the source is free, the sink solid.
CutGraph graph_of(const Delaunay& tetrahedra, Votes votes, double quality) {
  CutGraph graph{std::vector<std::uint32_t>(votes.no_surface.size()), std::move(votes.no_surface),
                 std::move(votes.free), std::move(votes.solid)};
  for (const Cell cell : tetrahedra.all_cell_handles()) {
    for (int i = 0; i < 4; ++i) {
      const Cell neighbor = cell->neighbor(i);
      const std::size_t side = 4 * std::size_t{cell->info()} + static_cast<std::size_t>(i);
      graph.opposite[side] = 4 * neighbor->info() + static_cast<std::uint32_t>(neighbor->index(cell));
      graph.capacity[side] += weight_of(quality * shape_cost(tetrahedra, cell, i));
    }
  }
  return graph;
}

std::vector<glm::uvec3> boundary(const Delaunay& tetrahedra, const std::vector<bool>& free) {
  std::vector<glm::uvec3> faces;
  for (const Cell cell : tetrahedra.all_cell_handles()) {
    if (free[cell->info()]) continue;
    for (int i = 0; i < 4; ++i) {
      if (!free[cell->neighbor(i)->info()] || tetrahedra.is_infinite(cell, i)) continue;
      // The triple turns clockwise as seen from outside of the cell, which is the free side.
      const auto corner = [&](int k) { return cell->vertex(Delaunay::vertex_triple_index(i, k))->info(); };
      faces.emplace_back(corner(0), corner(2), corner(1));
    }
  }
  return faces;
}

void check_field(const char* field, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument(std::string(field) + ": " + number_text(value) + ", must be in [" + number_text(least) +
                              ", " + number_text(most) + "]");
}

void check_deviations(std::span<const float> deviations, std::size_t points) {
  if (deviations.empty()) return;
  const bool are_lengths = std::all_of(deviations.begin(), deviations.end(),
                                       [](float deviation) { return deviation > 0 && std::isfinite(deviation); });
  if (deviations.size() == points && are_lengths) return;
  throw std::invalid_argument("deviations: must be none, or finite and above 0 for each of " + std::to_string(points) +
                              " points");
}

void check_views(std::span<const glm::dvec3> points, std::span<const std::vector<std::uint32_t>> views,
                 std::size_t centers) {
  if (views.size() != points.size()) {
    throw std::invalid_argument("views: " + std::to_string(views.size()) + " lists, must be one for each of " +
                                std::to_string(points.size()) + " points");
  }
  for (const std::vector<std::uint32_t>& list : views) {
    for (const std::uint32_t view : list) {
      if (view >= centers) {
        throw std::invalid_argument("views: " + std::to_string(view) + ", but there are " + std::to_string(centers) +
                                    " centers");
      }
    }
  }
}

}  // namespace

void check(const CutOptions& options) {
  check_field("quality", options.quality, 0, 1000);
  check_field("sure_views", options.sure_views, 0.1, 1000);
  check_field("noise", options.noise, 0.001, 100);
}

std::vector<glm::uvec3> cut_surface(std::span<const glm::dvec3> points,
                                    std::span<const std::vector<std::uint32_t>> views,
                                    std::span<const float> deviations, std::span<const glm::dvec3> centers,
                                    const CutOptions& options, const std::function<void(std::size_t)>& progress) {
  check(options);
  check_views(points, views, centers.size());
  check_deviations(deviations, points.size());
  if (std::all_of(views.begin(), views.end(), [](const auto& list) { return list.empty(); })) return {};
  const Delaunay tetrahedra = triangulation_of(points);
  if (tetrahedra.dimension() < 3) return {};
  VoteCounter counter(tetrahedra);
  const double usual_sigma = options.noise * median_edge(tetrahedra);
  for (const Delaunay::Vertex_handle p : tetrahedra.finite_vertex_handles()) {
    const auto n = static_cast<double>(views[p->info()].size());
    const double alpha_vis = 1 - std::exp(-n * n / (2 * options.sure_views * options.sure_views));
    const double sigma = deviations.empty() ? usual_sigma : double{deviations[p->info()]};
    for (const std::uint32_t view : views[p->info()]) counter.count(p, cgal(centers[view]), alpha_vis, sigma);
    progress(1);
  }
  for (const glm::dvec3& center : centers) {
    counter.count_outside(cgal(center));
    progress(0);
  }
  return boundary(tetrahedra, source_side(graph_of(tetrahedra, counter.take(), options.quality)));
}

}  // namespace lumatlas
