// SPDX-License-Identifier: GPL-3.0-or-later
// Says which cells stored views show, and keeps that from one surface to the next, so that only pixels that may show a
// change are looked at again. A picture of 160 x 120 pixels takes 77 KB.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <unordered_map>
#include <vector>

#include "mesh/camera.h"
#include "mesh/cells/cells.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// A part of space in which the surface has changed.
struct ChangedSphere {
  glm::dvec3 center;
  double radius;
};

class CellPictures {
 public:
  // The surface has become another. `now`: for each cell before its number now; CellId::none: it is changed or gone.
  void follow(std::span<const CellId> now);
  // Returns what count_cell_pixels() returns of what the view shows, and keeps its picture. If that of the surface
  // before was kept, of the same camera, only pixels that may show one of the spheres are traced: all that is changed,
  // new or gone must be within these. Throws what trace_wanted() throws, and std::out_of_range for a face that `cells`
  // do not know.
  [[nodiscard]] std::vector<CellPixels> count(ViewSlot slot, const Camera& camera, const Visibility& visibility,
                                              const Cells& cells, std::span<const ChangedSphere> changed);
  // Forgets the pictures of all other slots.
  void keep_only(std::span<const ViewSlot> slots);

 private:
  struct Picture {
    Camera camera;
    std::vector<CellId> cells;  // by pixel; none: no surface
  };
  std::unordered_map<std::uint32_t, Picture> pictures_;  // by view slot
};

}  // namespace lumatlas
