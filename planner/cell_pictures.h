// SPDX-License-Identifier: GPL-3.0-or-later
// Says which cells stored views show, and keeps that from one surface to the next, so that only pixels that may show a
// change are looked at again. A picture takes 4 bytes a pixel.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <unordered_map>
#include <vector>

#include "mesh/camera/camera.h"
#include "mesh/cells/cells.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// A part of space in which the surface has changed, in the frame of the surface and in scene units.
struct ChangedSphere {
  glm::dvec3 center;
  double radius;
};

class CellPictures {
 public:
  // Follows a surface that has become another. `now`: for each cell before its number now; CellId::none: it is changed
  // or gone. All that is changed, new or gone must be within the spheres.
  void follow(std::span<const CellId> now, std::span<const ChangedSphere> changed);
  // Returns what count_cell_pixels() returns of what the view shows, and keeps its picture. If one of the same camera
  // was kept, only pixels that may show what has changed since are traced; along an edge between cells, a pixel may
  // show the other one then. Throws what trace_wanted() throws, and std::out_of_range for a face that `cells` do not
  // know.
  [[nodiscard]] std::vector<CellPixels> count(ViewSlot slot, const Camera& camera, const Visibility& visibility,
                                              const Cells& cells);
  // Forgets the pictures of all other slots. `slots` ascend.
  void keep_only(std::span<const ViewSlot> slots);

 private:
  struct Picture {
    Camera camera;
    std::vector<CellId> cells;  // by pixel; none: no surface
  };
  std::unordered_map<std::uint32_t, Picture> pictures_;  // by view slot
};

}  // namespace lumatlas
