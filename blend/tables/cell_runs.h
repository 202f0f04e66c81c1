// SPDX-License-Identifier: GPL-3.0-or-later
// The part of a mesh that a camera can see at all, by the bounding spheres of its cells.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "mesh/camera/camera.h"
#include "mesh/cells/cells.h"

namespace lumatlas {

// Consecutive faces.
struct FaceRun {
  std::uint32_t first;
  std::uint32_t count;  // >= 1
};

// The mesh's faces in another order, in which those of a cell are neighbours.
class CellRuns {
 public:
  // Throws std::invalid_argument if `cells` are not those of a mesh with `faces` faces.
  CellRuns(const Cells& cells, std::size_t faces);

  // The mesh's number of each face, in this order; cells in theirs, and the mesh's order within a cell.
  [[nodiscard]] const std::vector<std::uint32_t>& order() const { return order_; }

  // Ascending runs of this order with every face that has a part in the image and in front of the camera, and as few
  // others as the cells' spheres can tell. Faces are not left out for facing away: they occlude others all the same.
  [[nodiscard]] std::vector<FaceRun> in_view(const Camera& camera) const;

 private:
  struct Sphere {
    glm::dvec3 center;
    double radius;
  };
  std::vector<Sphere> spheres_;               // one per cell
  std::vector<std::uint32_t> first_of_cell_;  // in the order; one more than there are cells
  std::vector<std::uint32_t> order_;
};

}  // namespace lumatlas
