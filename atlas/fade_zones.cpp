// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/fade_zones.h"

#include <stdexcept>
#include <string>

#include "mesh/visibility/visibility.h"

namespace lumatlas {

namespace {

bool is_zone(const CellShares::Zone& zone, std::size_t cells) {
  if (zone[0] >= cells) return false;
  for (std::size_t i = 1; i < zone.size(); ++i) {
    if (zone.at(i) == CellId::none) continue;
    if (zone.at(i) >= cells || zone.at(i - 1) == CellId::none || zone.at(i) <= zone.at(i - 1)) return false;
  }
  return true;
}

}  // namespace

void check(const CellShares& shares, std::size_t faces, std::size_t cells) {
  if (shares.zone_of_face.size() != faces || shares.corners.size() != faces) {
    throw std::invalid_argument("cell shares: are of " + std::to_string(shares.zone_of_face.size()) +
                                " faces, must be of " + std::to_string(faces));
  }
  for (std::size_t zone = 0; zone < shares.zones.size(); ++zone) {
    if (is_zone(shares.zones[zone], cells)) continue;
    throw std::invalid_argument("cell shares: the cells of zone " + std::to_string(zone) +
                                " do not rise, or are not of the surface");
  }
  for (std::size_t face = 0; face < faces; ++face) {
    if (shares.zone_of_face[face] < shares.zones.size()) continue;
    throw std::invalid_argument("cell shares: face " + std::to_string(face) + " is in zone " +
                                std::to_string(shares.zone_of_face[face]) + " of " +
                                std::to_string(shares.zones.size()));
  }
}

}  // namespace lumatlas
