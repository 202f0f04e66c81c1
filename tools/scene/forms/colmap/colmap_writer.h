// SPDX-License-Identifier: GPL-3.0-or-later
// COLMAP's binary model files, https://colmap.github.io/format.html: little-endian.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mesh/camera/camera.h"
#include "tools/scene/lenses/camera_model.h"

namespace lumatlas {

struct PointObservation {
  std::uint32_t image;  // index into the images
  glm::dvec2 position;  // image position, pixels
};

struct TrackedPoint {
  glm::dvec3 position{0.0};
  glm::u8vec3 color{0};
  std::vector<PointObservation> track;
};

struct WrittenView {
  std::string name;  // relative to images/, with '/' between folders
  Camera camera;
  std::optional<CameraModel> lens = {};  // one of COLMAP's models; none: that of the camera, PINHOLE
  std::uint32_t id = 0;                  // the image's; 0: its place in the order, from 1
};

// Writes cameras.bin, images.bin and points3D.bin into `folder`, which must exist. Images whose lenses are equal share
// a camera. Throws InputError where a file cannot be written, std::invalid_argument for a track that names no image,
// and for a lens that is none of COLMAP's.
void write_colmap_model(const std::filesystem::path& folder, std::span<const WrittenView> images,
                        std::span<const TrackedPoint> points);

}  // namespace lumatlas
