// SPDX-License-Identifier: GPL-3.0-or-later
// The frame of a mesh file against the frame of the poses: other units, other axes, a shifted origin.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "mesh/mesh.h"

namespace lumatlas {

// Takes a point of the mesh file to the frame of the poses: world = scale * (axes * mesh) + shift. The default changes
// nothing.
struct MeshFrame {
  glm::dmat3 axes{1.0};  // a signed permutation: one 1 or -1 in each row and column, else 0
  double scale = 1;      // scene units that one unit of the file is, finite and > 0
  glm::dvec3 shift{0};   // scene units, within 1e12 of 0

  bool operator==(const MeshFrame&) const = default;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const MeshFrame& frame);

// Returns the frame that applies `first` and then `second`.
[[nodiscard]] MeshFrame combined(const MeshFrame& first, const MeshFrame& second);

// Moves the positions, in double precision. Axes that mirror also turn every face round, so that a face keeps its
// outer side. Throws std::invalid_argument as check() does.
void move_to_frame_of_poses(TriangleSoup& soup, const MeshFrame& frame);

// Returns the matrix of axes for "x,-z,y": the x, y and z of the poses in terms of the mesh's x, y and z. Spaces,
// capitals, a plus sign and parentheses around the three do not matter. Throws std::invalid_argument, a sentence that
// begins with the text.
[[nodiscard]] glm::dmat3 parse_mesh_axes(std::string_view text);

// Returns "x,-z,y" for a matrix that parse_mesh_axes() can return.
[[nodiscard]] std::string mesh_axes_text(const glm::dmat3& axes);

// Returns the shift for "-500000,-4500000.25,0". Spaces and parentheses around the three do not matter. Throws
// std::invalid_argument, a sentence that begins with the text.
[[nodiscard]] glm::dvec3 parse_mesh_shift(std::string_view text);

// Returns the options of the program that give this frame: "--mesh-scale 0.001 --mesh-axes x,-z,y". What changes
// nothing is left out; of a frame that changes nothing at all it is "--mesh-scale 1".
[[nodiscard]] std::string mesh_frame_options(const MeshFrame& frame);

// {"mesh_scale": number, "mesh_axes": "x,-z,y", "mesh_shift": [x, y, z]}.
[[nodiscard]] nlohmann::json mesh_frame_json(const MeshFrame& frame);

}  // namespace lumatlas
