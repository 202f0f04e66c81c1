// SPDX-License-Identifier: GPL-3.0-or-later
// What the readers of mesh files have in common.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "mesh/base/errors.h"

namespace lumatlas {

// Appends the triangles that join a polygon's first corner with each of its other edges. One or two corners give one
// degenerate triangle, so that repair() can count it; none give nothing.
inline void append_fan(std::span<const std::uint32_t> corners, std::vector<glm::uvec3>& faces) {
  if (corners.empty()) return;
  if (corners.size() < 3) faces.emplace_back(corners.front(), corners.back(), corners.back());
  for (std::size_t i = 2; i < corners.size(); ++i) faces.emplace_back(corners[0], corners[i - 1], corners[i]);
}

[[nodiscard]] inline InputError no_faces(const std::string& path) {
  return InputError(path +
                    ": has no faces; a point cloud must be meshed first, for instance by Poisson reconstruction");
}

}  // namespace lumatlas
