// SPDX-License-Identifier: GPL-3.0-or-later
// The folder truth/ that a disturbed synthetic scene comes with, see write_synthetic_scene().
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>

#include "mesh/camera/camera.h"

namespace lumatlas {

// The true camera and exposure of a view that the scene describes with errors.
struct TrueView {
  Camera camera;
  glm::dvec3 gain{1.0};                       // that its photograph's linear light was multiplied by
  bool wrong = false;                         // its written pose is plainly wrong, rather than by pose noise
  std::optional<std::filesystem::path> mask;  // picture that is white where a passer-by is
};

// Returns the true views by name. `offset` is subtracted from camera positions, as by read_scene_views(). Throws
// InputError.
[[nodiscard]] std::map<std::string, TrueView> read_synthetic_truth(const std::filesystem::path& scene,
                                                                   const glm::dvec3& offset);

}  // namespace lumatlas
