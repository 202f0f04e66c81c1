// SPDX-License-Identifier: GPL-3.0-or-later
// The points of a scene, with the views that saw each, as far as that is known.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "tools/scene/scene.h"

namespace lumatlas {

// The arrays have one entry a point. Positions are in the scene's own coordinates, finite.
struct ScenePoints {
  std::filesystem::path file;
  std::vector<glm::dvec3> positions;
  std::vector<glm::u8vec3> colors;                // sRGB, or empty
  std::vector<glm::vec3> normals;                 // unit, (0, 0, 0) where the file has none that is finite; or empty
  std::vector<std::vector<std::uint32_t>> views;  // ranks of views, ascending; empty where nothing is known
  std::vector<float> deviations = {};             // standard deviation along the lines of sight, scene units; or empty
};

// Points from `given`, a PLY file. Without it: from a fused.ply in the scene, in dense/ or in dense/0/ (COLMAP's dense
// points), else from the COLMAP model's points3D.bin or points3D.txt, or what transforms.json names. Points that are
// not finite are left out. Throws InputError: file, index, value, what to do.
[[nodiscard]] ScenePoints read_scene_points(const std::filesystem::path& scene,
                                            const std::optional<std::filesystem::path>& given);

// Points from `given`, else those that came with the poses, with the views that saw them if that is known; none where
// there are none. Throws InputError.
[[nodiscard]] std::optional<ScenePoints> find_scene_points(const std::filesystem::path& scene,
                                                           const std::optional<std::filesystem::path>& given);

// Returns whether another program has left dense points in the scene.
[[nodiscard]] bool has_dense_points(const std::filesystem::path& scene);

}  // namespace lumatlas
