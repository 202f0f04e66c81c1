// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: parts of a picture, which are drawn one after another, so that what they are drawn into takes the
// memory of one part. The page does the same: partsOf() of tools/viewer/page/drawing/renderer.js.
#pragma once

#include <cstdint>
#include <vector>

#include "blend/outlines.h"
#include "blend/soft_edges.h"
#include "mesh/camera/camera.h"

namespace lumatlas {

// Pixels around a part that are drawn with it and not copied: soft_edges.h mixes pixels up to kEdgeReach away, of which
// each may be a mean of samples because of its neighbour, which may show a surface that is continued from kOutlineReach
// away.
inline constexpr std::uint32_t kAroundPart = kEdgeReach + 1 + kOutlineReach;

struct PartRect {
  std::uint32_t left, top, width, height;
};

// Pixels of the picture, from its top left corner.
struct PicturePart {
  PartRect drawn;
  PartRect copied;  // a part of `drawn`
};

// Returns parts of which `copied` covers a picture of that size, each of whose pixels is in one, row by row. All parts
// are drawn at the same size. `copied` is at most `most` pixels wide and high. All arguments are above 0.
[[nodiscard]] std::vector<PicturePart> parts_of(std::uint32_t width, std::uint32_t height, std::uint32_t most);

// Returns the camera whose picture is that part of the camera's picture.
[[nodiscard]] Camera camera_of_part(const Camera& camera, const PartRect& part);

}  // namespace lumatlas
