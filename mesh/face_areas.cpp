// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/face_areas.h"

#include <CGAL/Simple_cartesian.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace lumatlas {

namespace {

using Kernel = CGAL::Simple_cartesian<double>;

Kernel::Point_3 to_point(const glm::vec3& p) {
  return {p.x, p.y, p.z};
}

}  // namespace

std::vector<double> face_areas(const Mesh& mesh) {
  std::vector<double> areas(mesh.faces.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, areas.size()), [&](const auto& range) {
    const auto area = Kernel().compute_area_3_object();
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const glm::uvec3& face = mesh.faces[i];
      areas[i] =
          area(to_point(mesh.positions[face.x]), to_point(mesh.positions[face.y]), to_point(mesh.positions[face.z]));
    }
  });
  return areas;
}

}  // namespace lumatlas
