// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/collinear.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace lumatlas {

bool are_collinear(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  using ExactKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  const auto point = [](const glm::vec3& p) { return ExactKernel::Point_3(p.x, p.y, p.z); };
  return ExactKernel().collinear_3_object()(point(a), point(b), point(c));
}

}  // namespace lumatlas
