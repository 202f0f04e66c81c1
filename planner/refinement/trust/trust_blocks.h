// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to planner/: the blocks in which a photograph is compared with the other views, see trust.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace lumatlas {

// Blocks of pixels of a photograph, row by row, each with the surface point at its middle. Colours are square roots of
// linear light at the common exposure.
struct TrustGrid {
  std::uint32_t width, height;
  std::vector<glm::dvec3> color;
  // Range over the 3x3 blocks around. Where one of them is overexposed in a channel, and not in all, the photograph
  // does not say how bright that channel is, and `high` is kAnyBrightness.
  std::vector<glm::dvec3> low, high;
  [[nodiscard]] std::size_t size() const { return std::size_t{width} * height; }
};

inline constexpr double kAnyBrightness = 1e3;  // above every square root of linear light

// What the other views say of a block.
enum class Judgement : std::uint8_t {
  unjudged,
  trusted,       // they show about the same, or differ among themselves
  unknown,       // too few of them show it, or from too narrow an angle
  doubtful,      // they would contradict it if kDoubtful of the differences were enough
  contradicted,  // they agree with each other and not with it
};

inline constexpr double kDoubtful = 0.5;  // of TrustOptions::least_difference and least_to_spread

}  // namespace lumatlas
