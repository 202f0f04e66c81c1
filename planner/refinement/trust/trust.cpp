// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/trust/trust.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "mesh/base/requirement.h"
#include "planner/refinement/trust/trust_judge.h"
#include "planner/refinement/trust/trust_regions.h"

namespace lumatlas {

namespace {

// Returns the position of a pixel among the blocks' middles along one axis, held at the ends.
float block_position(std::uint32_t pixel, std::uint32_t pixels, std::uint32_t blocks) {
  const float position =
      (static_cast<float>(pixel) + 0.5f) * static_cast<float>(blocks) / static_cast<float>(pixels) - 0.5f;
  return std::clamp(position, 0.0f, static_cast<float>(blocks - 1));
}

// Bilinear between the blocks' middles.
std::vector<std::uint8_t> enlarged(const std::vector<std::uint8_t>& contradicted, const TrustGrid& grid,
                                   const PhotographSpan& photograph) {
  std::vector<std::uint8_t> mask(std::size_t{photograph.width} * photograph.height);
  const auto trust = [&](std::uint32_t x, std::uint32_t y) {
    return contradicted[std::size_t{y} * grid.width + x] ? 0.0f : 255.0f;
  };
  tbb::parallel_for(0u, photograph.height, [&](std::uint32_t py) {
    const float y = block_position(py, photograph.height, grid.height);
    const auto top = static_cast<std::uint32_t>(y);
    const std::uint32_t bottom = std::min(top + 1, grid.height - 1);
    for (std::uint32_t px = 0; px < photograph.width; ++px) {
      const float x = block_position(px, photograph.width, grid.width);
      const auto left = static_cast<std::uint32_t>(x);
      const std::uint32_t right = std::min(left + 1, grid.width - 1);
      const float above = glm::mix(trust(left, top), trust(right, top), x - static_cast<float>(left));
      const float below = glm::mix(trust(left, bottom), trust(right, bottom), x - static_cast<float>(left));
      mask[std::size_t{py} * photograph.width + px] =
          static_cast<std::uint8_t>(glm::mix(above, below, y - static_cast<float>(top)) + 0.5f);
    }
  });
  return mask;
}

constexpr Requirement trust_requires{"trust"};

}  // namespace

void check(const TrustOptions& options) {
  trust_requires(options.grid_px >= 8, "grid_px", options.grid_px, "at least 8");
  trust_requires(options.least_difference > 0 && options.least_difference <= 1, "least_difference",
                 options.least_difference, "in (0, 1]");
  trust_requires(std::isfinite(options.least_to_spread) && options.least_to_spread >= 0, "least_to_spread",
                 options.least_to_spread, "finite and not negative");
  trust_requires(options.least_views >= 1, "least_views", options.least_views, "at least 1");
  trust_requires(options.comparable_deg >= 0 && options.comparable_deg <= 180, "comparable_deg", options.comparable_deg,
                 "in [0, 180]");
  trust_requires(options.highlight_deg >= 0 && options.highlight_deg <= 180, "highlight_deg", options.highlight_deg,
                 "in [0, 180]");
}

std::vector<std::uint8_t> trust_mask(const Camera& camera, const Pyramid& photograph, const glm::dvec3& gain,
                                     const VisibilityBuffer& visible, const Atlas& atlas,
                                     std::span<const std::optional<ComparedView>> views, std::optional<ViewSlot> self,
                                     const TrustOptions& options, TrustExtent extent) {
  check(options);
  trust_requires.has_size(views.size(), atlas.capacity(), "views", "the atlas's capacity");
  trust_requires(photograph.level(0).width == camera.width, "camera.width", camera.width, "the photograph's");
  trust_requires(photograph.level(0).height == camera.height, "camera.height", camera.height, "the photograph's");
  trust_requires(visible.width >= 1 && visible.height >= 1, "visible.width", visible.width,
                 "at least 1, and so the height");
  const std::size_t pixels = std::size_t{visible.width} * visible.height;
  trust_requires.has_size(visible.depth.size(), pixels, "visible.depth", "the number of its pixels");
  trust_requires.has_size(visible.face.size(), pixels, "visible.face", "the number of its pixels");
  const TrustGrid grid = trust_grid(photograph, gain, visible);
  const TrustJudge judge(grid, camera, visible, atlas, views, self, options, extent);
  const std::vector<std::uint8_t> contradicted = contradicted_regions(
      grid, [&](std::size_t block) { return judge.at(block); }, extent);
  if (std::find(contradicted.begin(), contradicted.end(), 1) == contradicted.end()) return {};
  return enlarged(contradicted, grid, photograph.level(0));
}

}  // namespace lumatlas
