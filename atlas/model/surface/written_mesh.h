// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: a mesh as it is written, with a vertex for each cell, fade zone and place in the base texture
// that a corner of its faces has.
#pragma once

#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "atlas/base_texture.h"
#include "atlas/fade_zones.h"
#include "atlas/surface.h"
#include "mesh/mesh.h"

namespace lumatlas {

// Numbers the pairs of a cell and the cells that faces of it fade between, which the meshes of a model share.
class DrawZones {
 public:
  explicit DrawZones(const CellShares& shares) : shares_(shares) {}

  // Returns the zone of a face of a cell. `face` counts over all meshes of the surface.
  [[nodiscard]] std::uint32_t of(std::size_t face, CellId cell);
  [[nodiscard]] glm::u8vec4 shares(std::size_t face, int corner) const;
  // Returns how many cells the faces of a zone fade between, 1 to kCellsPerZone.
  [[nodiscard]] std::size_t cells_of(std::uint32_t zone) const;
  [[nodiscard]] std::size_t count() const { return zones_.size(); }
  // Returns the cells of all zones: that of the faces of each; the first that they fade between, the second, ...;
  // CellId::none after the last of a zone.
  [[nodiscard]] std::vector<std::uint32_t> cells() const;

 private:
  const CellShares& shares_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> numbers_;  // of a zone of shares_ and a cell
  std::vector<std::uint32_t> zones_;                                          // the zone of shares_ of each
  std::vector<std::uint32_t> own_cells_;                                      // the cell of the faces of each
};

// One value per vertex in each array, or none.
struct WrittenMesh {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> sources;  // the given vertex that it is
  std::vector<float> cells;
  std::vector<float> zones;           // none without zones
  std::vector<glm::u8vec4> shares;    // of the zone's cells, 255 is 1
  std::vector<glm::u16vec2> places;   // none without a base texture
  std::vector<glm::uvec3> faces;      // in their order
  std::vector<std::uint32_t> copies;  // which earlier vertex each of the last ones is a copy of
};

// A surface as it is written, in the model's frame.
struct WrittenSurface {
  WrittenMesh near, far;                  // the far sphere; no face without one
  std::vector<std::uint32_t> zone_cells;  // DrawZones::cells()
};

// `shares` and `places`, which are of the near faces, may be null. Without shares there are no zones; nor for more than
// kMostZones. `packed`: the same surface in few bytes once it is compressed: faces and vertices in an order in which
// neighbours follow each other, and positions on a grid of 24 bits that is at most so wide, scene units, unless the
// mesh is too large for it.
[[nodiscard]] WrittenSurface written_surface(const Surface& surface, const CellShares* shares,
                                             const TexturePlaces* places, std::optional<double> packed);

// Puts positions on a grid that is at most `step` wide, scene units, unless they are too large for 24 bits of it.
void snap_to_grid(std::vector<glm::vec3>& positions, double step);

inline constexpr std::size_t kMostZones = 1u << 24;  // whole numbers up to this are exact in a float

// The vertices' colours, given for each vertex that they copy, in sRGB: linear light in 16 bits, which tell apart what
// sRGB does. `packed`: of all values that become the same in sRGB again, those that compress best.
[[nodiscard]] std::vector<glm::u16vec4> linear_colors(std::span<const glm::u8vec3> given,
                                                      std::span<const std::uint32_t> sources, bool packed);

}  // namespace lumatlas
