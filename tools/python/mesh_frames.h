// SPDX-License-Identifier: GPL-3.0-or-later
// The frame of a mesh file as Python gives it.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "tools/scene/mesh/mesh_frame.h"

namespace lumatlas::python {

// Returns the frame, or none where no part of it is given. Throws std::invalid_argument.
[[nodiscard]] inline std::optional<MeshFrame> mesh_frame_of(const std::optional<double>& mesh_scale,
                                                            const std::optional<std::string>& mesh_axes,
                                                            const std::optional<std::array<double, 3>>& mesh_shift) {
  if (!mesh_scale && !mesh_axes && !mesh_shift) return std::nullopt;
  MeshFrame frame;
  if (mesh_axes) frame.axes = parse_mesh_axes(*mesh_axes);
  frame.scale = mesh_scale.value_or(1);
  if (mesh_shift) frame.shift = {(*mesh_shift)[0], (*mesh_shift)[1], (*mesh_shift)[2]};
  check(frame);
  return frame;
}

}  // namespace lumatlas::python
