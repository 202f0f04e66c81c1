// SPDX-License-Identifier: GPL-3.0-or-later
// The shares of neighbouring cells in the surface along their borders, as it is drawn: see
// blend/tables/fade_zone_shares.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <vector>

#include "mesh/base/id.h"

namespace lumatlas {

// Cells that share one face, at most. Where more come near, those that are farthest from its corners are taken away
// from them, which keeps shares continuous; no vertex loses its last cell.
inline constexpr std::size_t kCellsPerZone = 4;

// Faces that the same cells share are a zone.
struct CellShares {
  using Zone = std::array<CellId, kCellsPerZone>;  // cells, ascending; CellId::none after the last
  std::vector<Zone> zones;
  std::vector<std::uint32_t> zone_of_face;        // one per face
  std::vector<std::array<glm::vec4, 3>> corners;  // per face and corner, the shares of its zone's cells; sum 1
};

// Throws std::invalid_argument, naming the entry, unless there is one zone and three corners for each of the `faces`
// faces, every number is one of a zone, and zones name ascending cells of `cells`.
void check(const CellShares& shares, std::size_t faces, std::size_t cells);

}  // namespace lumatlas
