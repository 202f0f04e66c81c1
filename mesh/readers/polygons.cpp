// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/readers/polygons.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

namespace lumatlas {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
enum class Side { unknown, outside, inside };
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;  // the corner's vertex
using FaceBase =
    CGAL::Constrained_triangulation_face_base_2<Kernel, CGAL::Triangulation_face_base_with_info_2<Side, Kernel>>;
using Triangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
                                               CGAL::No_constraint_intersection_requiring_constructions_tag>;
using VertexHandle = Triangulation::Vertex_handle;
// Number of times that the outline passes along an edge: twice where a bridge joins a hole to it.
using Edge = std::pair<VertexHandle, VertexHandle>;
using Passes = std::map<Edge, unsigned>;

constexpr std::uint32_t kLargestFan = 8;  // corners

// A polygon seen along an axis, so that coordinates stay as they are.
struct Outline {
  std::vector<std::uint32_t> vertices;
  std::vector<Kernel::Point_2> points;
  double area = 0;  // signed
};

double doubled_area(const Kernel::Point_2& a, const Kernel::Point_2& b, const Kernel::Point_2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// Newell's: of any polygon the sum of the areas that its edges span with its first corner.
glm::dvec3 area_vector(const std::vector<std::uint32_t>& vertices, const std::vector<glm::dvec3>& positions) {
  glm::dvec3 sum(0);
  const glm::dvec3& first = positions[vertices[0]];
  for (std::size_t i = 2; i < vertices.size(); ++i) {
    sum += glm::cross(positions[vertices[i - 1]] - first, positions[vertices[i]] - first) / 2.0;
  }
  return sum;
}

int longest_axis(const glm::dvec3& v) {
  const glm::dvec3 length = glm::abs(v);
  if (length.x >= length.y && length.x >= length.z) return 0;
  return length.y >= length.z ? 1 : 2;
}

// Returns nothing if the polygon has no area, or none that is finite.
std::optional<Outline> outline_of(std::vector<std::uint32_t> vertices, const std::vector<glm::dvec3>& positions) {
  const glm::dvec3 area = area_vector(vertices, positions);
  const int axis = longest_axis(area);
  if (!std::isfinite(area.x + area.y + area.z) || area[axis] == 0) return std::nullopt;
  Outline outline;
  outline.area = area[axis];
  outline.points.reserve(vertices.size());
  for (const std::uint32_t vertex : vertices) {
    outline.points.emplace_back(positions[vertex][(axis + 1) % 3], positions[vertex][(axis + 2) % 3]);
  }
  outline.vertices = std::move(vertices);
  return outline;
}

// Returns whether every triangle of the fan turns as the polygon does.
bool is_covered_by_fan(const Outline& outline) {
  for (std::size_t i = 2; i < outline.points.size(); ++i) {
    const double area = doubled_area(outline.points[0], outline.points[i - 1], outline.points[i]);
    if (!(outline.area > 0 ? area > 0 : area < 0)) return false;
  }
  return true;
}

Edge edge_between(VertexHandle a, VertexHandle b) {
  return a < b ? Edge(a, b) : Edge(b, a);
}

// The triangulation of the outline's corners, with its edges as constraints, and how often the outline passes along
// each. False if an edge goes through a corner; throws if two edges cross.
bool constrain(const Outline& outline, Triangulation& triangulation, Passes& passes) {
  std::vector<std::pair<Kernel::Point_2, std::uint32_t>> corners;
  for (std::size_t i = 0; i < outline.points.size(); ++i) corners.emplace_back(outline.points[i], outline.vertices[i]);
  triangulation.insert(corners.begin(), corners.end());  // in an order of its own, which is fast
  VertexHandle previous = triangulation.insert(outline.points.back());
  for (const Kernel::Point_2& point : outline.points) {
    const VertexHandle vertex = triangulation.insert(point, previous->face());
    if (vertex != previous) {
      triangulation.insert_constraint(previous, vertex);
      if (!triangulation.is_edge(previous, vertex)) return false;
      ++passes[edge_between(previous, vertex)];
    }
    previous = vertex;
  }
  return true;
}

// Marks every face as inside or outside: the side changes where the outline passes an odd number of times.
void mark_sides(Triangulation& triangulation, const Passes& passes) {
  for (const Triangulation::Face_handle face : triangulation.all_face_handles()) face->info() = Side::unknown;
  std::vector<Triangulation::Face_handle> front{triangulation.infinite_face()};
  front.back()->info() = Side::outside;
  while (!front.empty()) {
    const Triangulation::Face_handle face = front.back();
    front.pop_back();
    for (int i = 0; i < 3; ++i) {
      const Triangulation::Face_handle neighbor = face->neighbor(i);
      if (neighbor->info() != Side::unknown) continue;
      const Edge edge = edge_between(face->vertex(Triangulation::ccw(i)), face->vertex(Triangulation::cw(i)));
      const auto found = passes.find(edge);
      const bool changes = found != passes.end() && found->second % 2 == 1;
      neighbor->info() = (face->info() == Side::inside) != changes ? Side::inside : Side::outside;
      front.push_back(neighbor);
    }
  }
}

// Returns nothing if the outline crosses itself, or touches itself along an edge.
std::optional<std::vector<glm::uvec3>> triangles_of(const Outline& outline) {
  try {
    Passes passes;
    Triangulation triangulation;
    if (!constrain(outline, triangulation, passes)) return std::nullopt;
    mark_sides(triangulation, passes);
    std::vector<glm::uvec3> triangles;
    for (const Triangulation::Face_handle face : triangulation.finite_face_handles()) {
      if (face->info() != Side::inside) continue;
      glm::uvec3 corners(face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info());
      if (outline.area < 0) std::swap(corners.y, corners.z);
      triangles.push_back(corners);
    }
    return triangles;
  } catch (const Triangulation::Intersection_of_constraints_exception&) {
    return std::nullopt;
  }
}

}  // namespace

std::optional<std::vector<glm::uvec3>> triangulated(std::vector<std::uint32_t> corners,
                                                    const std::vector<glm::dvec3>& positions) {
  if (corners.size() < 3) return std::nullopt;
  const std::size_t count = corners.size() - 2;
  const auto outline = outline_of(std::move(corners), positions);
  auto triangles = outline ? triangles_of(*outline) : std::nullopt;
  if (triangles && triangles->size() != count) return std::nullopt;
  return triangles;
}

void Polygons::append(std::span<const std::uint32_t> corners, std::vector<glm::uvec3>& faces) {
  if (corners.empty()) return;
  if (corners.size() < 3) faces.emplace_back(corners.front(), corners.back(), corners.back());
  if (corners.size() > 3) fans_.push_back({faces.size(), static_cast<std::uint32_t>(corners.size())});
  for (std::size_t i = 2; i < corners.size(); ++i) faces.emplace_back(corners[0], corners[i - 1], corners[i]);
}

void Polygons::triangulate(const Fan& fan, TriangleSoup& soup) {
  const std::size_t count = fan.corners - 2;
  std::vector<std::uint32_t> vertices{soup.faces[fan.first].x, soup.faces[fan.first].y};
  for (std::size_t i = 0; i < count; ++i) vertices.push_back(soup.faces[fan.first + i].z);
  const auto outline = outline_of(std::move(vertices), soup.positions);
  if (!outline || (fan.corners <= kLargestFan && is_covered_by_fan(*outline))) return;
  auto triangles = triangles_of(*outline);
  if (!triangles || triangles->empty() || triangles->size() > count) return;
  triangles->resize(count, glm::uvec3(outline->vertices[0]));
  std::copy(triangles->begin(), triangles->end(), soup.faces.begin() + static_cast<std::ptrdiff_t>(fan.first));
}

void Polygons::triangulate(TriangleSoup& soup) const {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, fans_.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) triangulate(fans_[i], soup);
  });
}

}  // namespace lumatlas
