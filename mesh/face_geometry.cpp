// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/face_geometry.h"

#include <CGAL/Simple_cartesian.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>

namespace lumatlas {

namespace {

using DoubleKernel = CGAL::Simple_cartesian<double>;

DoubleKernel::Point_3 to_point(const glm::vec3& p) {
  return {p.x, p.y, p.z};
}

FaceGeometry geometry_of(const DoubleKernel::Point_3& a, const DoubleKernel::Point_3& b,
                         const DoubleKernel::Point_3& c) {
  FaceGeometry geometry;
  geometry.area = CGAL::sqrt(CGAL::squared_area(a, b, c));
  const DoubleKernel::Vector_3 normal = CGAL::cross_product(b - a, c - a);  // CGAL::normal() wants some area
  const double length = CGAL::sqrt(normal.squared_length());
  if (length > 0) geometry.normal = {normal.x() / length, normal.y() / length, normal.z() / length};
  return geometry;
}

}  // namespace

std::vector<FaceGeometry> face_geometry(const Mesh& mesh) {
  std::vector<FaceGeometry> geometry(mesh.faces.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, geometry.size(), 1024), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const glm::uvec3& face = mesh.faces[i];
      geometry[i] = geometry_of(to_point(mesh.positions[face.x]), to_point(mesh.positions[face.y]),
                                to_point(mesh.positions[face.z]));
    }
  });
  return geometry;
}

}  // namespace lumatlas
