// SPDX-License-Identifier: GPL-3.0-or-later
// From a scene's mesh file to the surface that views are planned on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/cells.h"
#include "mesh/repair.h"

namespace lumatlas {

struct SurfaceInput {
  std::shared_ptr<const Surface> surface;
  std::filesystem::path mesh_file;
  std::uint64_t file_vertices = 0;
  std::uint64_t file_faces = 0;
  bool file_has_colors = false;
  RepairReport repair;
  std::uint64_t closed_holes = 0;     // see mesh/holes.h
  std::uint64_t split_faces = 0;      // faces added by splitting those that were larger than a cell
  std::vector<std::string> warnings;  // what a user should know of the mesh, in sentences
};

// What is subtracted from all coordinates before they become floats: the middle of the box of the faces whose corners
// are finite. Where some are so far away that floats around it would be too coarse for the others, the middle of the
// box of all but the outermost hundredth of the corners on each side. The coordinates' origin if there is no such face.
[[nodiscard]] glm::dvec3 scene_origin(const TriangleSoup& soup);

// Reads, centres (the offset is scene_origin()), repairs, closes holes up to `largest_hole` across (scene units; 0:
// none), splits faces larger than a cell, makes cells. Throws InputError, and Interrupted soon after a signal.
[[nodiscard]] SurfaceInput load_surface(const std::filesystem::path& scene,
                                        const std::optional<std::filesystem::path>& mesh_file, CellOptions options,
                                        double largest_hole = 0);

}  // namespace lumatlas
