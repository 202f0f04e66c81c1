// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: is a triangle list already an oriented manifold? Cheaper than repairing it to find out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lumatlas {

// True if the faces around every vertex form one fan, open or closed, whose faces all turn the same way, and no two
// faces have the same three vertices. Then no edge has three faces and orienting would change nothing.
// Each face must have three different vertices.
[[nodiscard]] bool is_oriented_manifold(std::size_t vertices, const std::vector<std::array<std::uint32_t, 3>>& faces);

}  // namespace lumatlas
