// SPDX-License-Identifier: GPL-3.0-or-later
// Key frames in a JSON file, described in tools/picture/README.md.
#pragma once

#include <filesystem>
#include <vector>

#include "tools/picture/paths/camera_path.h"

namespace lumatlas {

// The values of a key frame that does not state them.
struct PathDefaults {
  glm::dvec3 offset{0.0};  // subtracted from every point: that of the model, since the file has the input's coordinates
  glm::dvec3 up{0, 0, 1};
  double fov_deg = 70;
};

// Throws InputError: file, number of the key frame, what is wrong with it.
[[nodiscard]] std::vector<KeyFrame> read_path(const std::filesystem::path& file, const PathDefaults& defaults);

}  // namespace lumatlas
