// SPDX-License-Identifier: GPL-3.0-or-later
// The cameras, posed images and points of a COLMAP model, binary or text.
//
// Since 3.12 a model also has rigs and frames, whose product is the pose of each image. The file of images still holds
// that product, complete and in the old layout, so rigs and frames need not be read.
//
// The parsers take a file's bytes and its path, which only their messages use. They check every value, allocate no more
// than a small multiple of the bytes that they are given, and throw InputError: path, index or line, value, rule.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/scene/forms/capture.h"
#include "tools/scene/lenses/camera_model.h"

namespace lumatlas {

struct ColmapCamera {
  std::uint32_t id = 0;
  CameraModel lens;      // passes check()
  std::string bad = {};  // why it cannot be used: the lens then does not pass. See BadPhotographs
};

struct ColmapImage {
  std::uint32_t id = 0;
  std::uint32_t camera_id = 0;
  std::string name;                                // relative to the folder of photographs, as it is written
  glm::dquat cam_from_world_rotation{1, 0, 0, 0};  // unit
  glm::dvec3 cam_from_world_translation{0.0};      // model units, each within 1e12
  std::string bad = {};                            // why its pose cannot be used
};

// A point that images were matched at.
struct ColmapPoint {
  glm::dvec3 position{0.0};           // model units, each within 1e12
  glm::u8vec3 color{0};               // sRGB
  std::vector<std::uint32_t> images;  // ids of the images that saw it, as listed; an image may occur twice
};

// Each parser returns the records in the order of the file; ids and names occur once, those of points are not looked
// at. Where bad ones are kept, names may occur more than once.
[[nodiscard]] std::vector<ColmapCamera> parse_cameras_binary(std::span<const std::byte> file,
                                                             const std::filesystem::path& path,
                                                             BadPhotographs bad = BadPhotographs::refuse);
[[nodiscard]] std::vector<ColmapCamera> parse_cameras_text(std::string_view file, const std::filesystem::path& path,
                                                           BadPhotographs bad = BadPhotographs::refuse);
[[nodiscard]] std::vector<ColmapImage> parse_images_binary(std::span<const std::byte> file,
                                                           const std::filesystem::path& path,
                                                           BadPhotographs bad = BadPhotographs::refuse);
// The lines of 2D points may be missing, all of them or some.
[[nodiscard]] std::vector<ColmapImage> parse_images_text(std::string_view file, const std::filesystem::path& path,
                                                         BadPhotographs bad = BadPhotographs::refuse);
[[nodiscard]] std::vector<ColmapPoint> parse_points_binary(std::span<const std::byte> file,
                                                           const std::filesystem::path& path);
[[nodiscard]] std::vector<ColmapPoint> parse_points_text(std::string_view file, const std::filesystem::path& path);

struct ColmapModel {
  std::filesystem::path cameras_path, images_path;  // the files
  std::vector<ColmapCamera> cameras;                // sorted by id
  std::vector<ColmapImage> images;                  // sorted by name, in byte order; at least one
  std::string note = {};                            // a sentence on which of several was read; empty: there is one

  // Every image's camera is there. Throws InputError for an id that no camera has.
  [[nodiscard]] const ColmapCamera& camera_of(const ColmapImage& image) const;
};

// The model in `scene`/sparse, else the one with most images in the folders of `scene`/sparse, where COLMAP's mapper
// leaves several, else the one in `scene` itself; binary before text, as COLMAP does. Throws InputError.
[[nodiscard]] ColmapModel read_colmap_model(const std::filesystem::path& scene,
                                            BadPhotographs bad = BadPhotographs::refuse);

// The photographs of that model, each with its image's id.
[[nodiscard]] Capture read_colmap(const CaptureRequest& request);

// The images of the model that read_colmap_model() reads; none where no model is whole. Never throws: what cannot be
// looked at is not there.
[[nodiscard]] std::optional<std::filesystem::path> find_colmap_images(const std::filesystem::path& scene);

// The points that lie beside the model's images, in the same form. Throws InputError, also where that file is missing.
[[nodiscard]] std::vector<ColmapPoint> read_colmap_points(const ColmapModel& model);

// The file of the points beside the model's images, which need not be there.
[[nodiscard]] std::filesystem::path points_path(const ColmapModel& model);

}  // namespace lumatlas
