// SPDX-License-Identifier: GPL-3.0-or-later
// Scores of pictures whose poses were refined, over the same pixels of the mesh for every method. Those over the whole
// frame need no such care: a frame is the same pixels from every pose.
//
// Each method has a pose of its own, from which the mesh covers other pixels of the photograph. Scored each on its own
// pixels, a method would gain by a pose that leaves out what it shows badly.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "atlas/images/photograph.h"
#include "tools/score/measures/scores.h"

namespace lumatlas {

// The picture of a method from the refined pose of a photograph.
struct AlignedPicture {
  Photograph picture;
  Photograph frame;                // the picture with its background
  std::vector<std::uint8_t> seen;  // one entry per pixel: not 0 where the mesh is seen
};

// 1 where the mesh is seen from the given pose and in every picture, so that these pixels are some of those that the
// other scores are over. Throws std::invalid_argument unless all have as many pixels.
[[nodiscard]] std::vector<std::uint8_t> seen_by_all(std::span<const std::uint8_t> at_given,
                                                    std::span<const AlignedPicture> pictures);

// Sets `aligned` and `aligned_pixels`. `fitted` is an aligned picture after its gain. Throws as scores.h does.
void add_aligned_scores(const Photograph& fitted, const Photograph& photograph, std::span<const std::uint8_t> mask,
                        RegionScores& scores);

}  // namespace lumatlas
