// SPDX-License-Identifier: GPL-3.0-or-later
// PatchMatch stereo: finds for every pixel of a photograph the plane by which other photographs show the same there.
//
// Planes come from seeds and from chance, and good ones spread (Bleyer et al., "PatchMatch stereo", 2011). They spread
// on a checkerboard, from pixels of one colour to those of the other (Galliani et al., "Massively parallel multiview
// stereopsis by surface normal diffusion", 2015). The eight regions are those of Xu and Tao, "Multi-scale geometric
// consistency guided multi-view stereo", 2019. Coarse to fine: what a coarse picture decides is only refined in a finer
// one, which makes smooth walls and long ways cheap. A plane costs the mean of its two cheapest photographs, so that
// what one or two of four do not see can still be found.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "tools/stereo/luma_image.h"
#include "tools/stereo/patch_cost.h"

namespace lumatlas {

// One plane a pixel, row by row. Pixels that are not valid have w = 0 and cost kLargestPatchCost.
struct PlaneMap {
  std::uint32_t width = 0, height = 0;
  std::vector<SlantedPlane> planes;
  std::vector<float> costs;
};

// Range of inverse depths to search, 1 / scene units, 0 <= least < most.
struct InverseDepthRange {
  float least = 0, most = 0;
};

// A known surface point, such as one of structure from motion.
struct DepthSeed {
  glm::vec2 place;  // in shares of the picture's width and height, [0, 1)
  float w = 0;      // 1 / depth
};

// The photograph whose depths are estimated, and one or more photographs that it is matched with.
struct MatchedViews {
  const LumaPyramid* reference = nullptr;
  std::vector<const LumaPyramid*> others;
};

// Returns planes for the reference's finest level. The result is the same for any number of threads and every machine.
[[nodiscard]] PlaneMap match_patches(const MatchedViews& views, const InverseDepthRange& range,
                                     std::span<const DepthSeed> seeds);

// Returns `start` after more rounds in which a plane's cost grows with its reprojection error there and back, by the
// planes of the other photographs. `other_planes`: one map for each of views.others, of its finest level.
[[nodiscard]] PlaneMap match_consistently(const MatchedViews& views, const InverseDepthRange& range, PlaneMap start,
                                          std::span<const PlaneMap* const> other_planes);

// Returns the reprojection error there and back, in pixels: from `pixel`, an image position, to another photograph by
// the inverse depth `w`, and back by the plane there. Infinite if the point is not in that photograph or it has no
// plane.
[[nodiscard]] float way_back_px(glm::vec2 pixel, float w, const PixelTransfer& there, const PixelTransfer& back,
                                const PlaneMap& other);

}  // namespace lumatlas
