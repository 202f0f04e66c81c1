// SPDX-License-Identifier: GPL-3.0-or-later
// The frames of a capture with depth images, in the order and at the times at which they were taken.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "tools/scene/scene.h"

namespace lumatlas {

// A photograph, a depth image, or both where they were taken together.
struct CapturedFrame {
  double time = 0;                   // seconds since the first frame
  std::optional<std::size_t> view;   // of CapturedStream::scene
  std::optional<std::size_t> depth;  // the same of its depth images
};

struct CapturedStream {
  SceneViews scene;                   // relative to `offset`
  glm::dvec3 offset{0};               // the place of the first photograph
  std::vector<CapturedFrame> frames;  // by time; what is held out is in none
  std::vector<std::size_t> held_out;  // ranks of the views that are in no frame
};

// Reads the capture in a folder. Times are those of a TUM folder's rgb.txt and depth.txt; of a form without times,
// `rate` photographs follow each other in a second by name, each with the depth image of its pose. Throws InputError,
// also for a capture without depth images, and what split() throws.
[[nodiscard]] CapturedStream read_captured_stream(const std::filesystem::path& folder, const PictureFolders& folders,
                                                  const std::optional<HoldOut>& hold_out, double rate);

}  // namespace lumatlas
