// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/repair/: a hash by which vertices at one place are found.
#pragma once

#include <bit>
#include <cstdint>
#include <glm/vec3.hpp>

namespace lumatlas {

// Returns the same for places that are equal, -0 and 0 among them. A crafted mesh may have many places of one hash.
[[nodiscard]] inline std::uint64_t hash_of_place(const glm::vec3& place) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    hash ^= std::bit_cast<std::uint32_t>(place[axis] + 0.0F);  // -0 becomes 0
    hash *= 0x9e3779b97f4a7c15ull;
    hash ^= hash >> 32U;
  }
  return hash;
}

}  // namespace lumatlas
