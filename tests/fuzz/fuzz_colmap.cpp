// SPDX-License-Identifier: GPL-3.0-or-later
// COLMAP's binary and text readers, and the lens models with whatever parameters come out of them. The first byte of
// the input chooses the reader. Every input must be taken or get one line of an InputError.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string_view>

#include "tests/fuzz/laws/capture_laws.h"
#include "tests/fuzz/laws/sentence_laws.h"
#include "tools/scene/forms/colmap/colmap.h"
#include "tools/scene/lenses/undistortion.h"

namespace {

using namespace lumatlas;

void use(const std::vector<ColmapCamera>& cameras) {
  for (const ColmapCamera& camera : cameras) {
    check(camera.lens);
    try {
      check(pinhole_view(camera.lens));
    } catch (const std::invalid_argument&) {  // a panorama, or folded over
    }
    if (can_be_pinhole(camera.lens.model)) {
      const auto image = image_from_cam(camera.lens, {0.3, -0.4, 1});
      require(!image || (std::isfinite(image->x) && std::isfinite(image->y)));
    }
  }
}

Capture photographs_named(const std::vector<ColmapImage>& images) {
  Capture capture;
  for (const ColmapImage& image : images) capture.photographs.push_back({image.name, "images/" + image.name});
  return capture;
}

void use(const std::vector<ColmapImage>& images) {
  for (const ColmapImage& image : images) {
    require(std::abs(glm::length(image.cam_from_world_rotation) - 1) < 1e-9);
    require(!image.name.empty());
  }
  require_inside(photographs_named(images));
}

void use(const std::vector<ColmapPoint>& points) {
  for (const ColmapPoint& point : points) {
    for (int axis = 0; axis < 3; ++axis) require(std::abs(point.position[axis]) <= 1e12);
  }
}

void read(std::uint8_t reader, std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  switch (reader % 6) {
    case 0:
      return use(parse_cameras_binary(bytes, "cameras.bin"));
    case 1:
      return use(parse_images_binary(bytes, "images.bin"));
    case 2:
      return use(parse_cameras_text(text, "cameras.txt"));
    case 3:
      return use(parse_images_text(text, "images.txt"));
    case 4:
      return use(parse_points_binary(bytes, "points3D.bin"));
    default:
      return use(parse_points_text(text, "points3D.txt"));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  lumatlas::check_refusal([&] { read(data[0], std::as_bytes(std::span(data + 1, size - 1))); });
  return 0;
}
