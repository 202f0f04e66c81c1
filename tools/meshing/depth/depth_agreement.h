// SPDX-License-Identifier: GPL-3.0-or-later
// Tests whether depth images show the same surface, which reveals a wrong unit, wrong poses and images of another
// scene.
#pragma once

#include <cstddef>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "tools/meshing/depth/depth_fusion.h"

namespace lumatlas {

// Some of the measured points of all depth images, evenly.
struct DepthSamples {
  std::vector<glm::dvec3> positions;  // in the frame of the cameras
  std::vector<std::uint32_t> image;   // that it was measured in
  std::vector<double> pixel_width;    // a pixel of its image at its depth, scene units
  std::vector<double> depth;          // z in that image
  std::size_t measured = 0;           // pixels of all images
};

// About `most` of them. `progress` is called with the images read since the last call.
[[nodiscard]] DepthSamples sample_depths(std::size_t count, const DepthSource& image, std::size_t most,
                                         const std::function<void(std::size_t)>& progress);

// Counts of samples, looked up in the views of other images.
struct DepthAgreement {
  std::size_t confirmed = 0;     // the image has that depth there
  std::size_t seen_through = 0;  // it has a larger one, as if nothing were there
  std::size_t hidden = 0;        // it has a smaller one: something stands before it, or one of the two is wrong

  [[nodiscard]] std::size_t compared() const { return confirmed + seen_through + hidden; }
};

inline constexpr std::size_t kMostAgreementImages = 200;  // that are looked through, evenly over all
// Depths closer than this are the same: what fusion averages, and what sensors are wrong by.
inline constexpr double kSameDepthPixels = 4;
inline constexpr double kSameDepthShare = 0.02;

[[nodiscard]] DepthAgreement depth_agreement(const DepthSamples& samples, std::size_t count, const DepthSource& image,
                                             const std::function<void(std::size_t)>& progress);

}  // namespace lumatlas
