// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/face_geometry.h"

#include <CGAL/Simple_cartesian.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <array>

namespace lumatlas {

namespace {

using DoubleKernel = CGAL::Simple_cartesian<double>;

DoubleKernel::Point_3 to_point(const glm::vec3& p) {
  return {p.x, p.y, p.z};
}

using Corners = std::array<DoubleKernel::Point_3, 3>;

double area_of(const Corners& at) {
  return CGAL::sqrt(CGAL::squared_area(at[0], at[1], at[2]));
}

FaceGeometry geometry_of(const Corners& at) {
  FaceGeometry geometry;
  geometry.area = area_of(at);
  // CGAL::normal() wants some area.
  const DoubleKernel::Vector_3 normal = CGAL::cross_product(at[1] - at[0], at[2] - at[0]);
  const double length = CGAL::sqrt(normal.squared_length());
  if (length > 0) geometry.normal = {normal.x() / length, normal.y() / length, normal.z() / length};
  return geometry;
}

// Calls the function with the corners of each face, and returns its values.
template <typename Function>
auto of_each_face(const Mesh& mesh, const Function& function) {
  std::vector<decltype(function(Corners()))> values(mesh.faces.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, values.size(), 1024), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const glm::uvec3& face = mesh.faces[i];
      values[i] = function(
          {to_point(mesh.positions[face.x]), to_point(mesh.positions[face.y]), to_point(mesh.positions[face.z])});
    }
  });
  return values;
}

}  // namespace

std::vector<FaceGeometry> face_geometry(const Mesh& mesh) {
  return of_each_face(mesh, geometry_of);
}

std::vector<double> face_areas(const Mesh& mesh) {
  return of_each_face(mesh, area_of);
}

}  // namespace lumatlas
