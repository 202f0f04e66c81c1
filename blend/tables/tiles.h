// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures that are larger than what is drawn at once, in tiles: cameras with the same pose that see a part of the
// image each. A picture's exposure depends on its camera's pose alone, so the tiles meet without a seam.
#pragma once

#include <cstdint>
#include <vector>

#include "blend/renderer.h"

namespace lumatlas {

// The renderer draws a tile in parts (RendererOptions::part_px). Beside a part, a tile takes 4 bytes of GL memory a
// pixel.
inline constexpr std::uint32_t kTileSide = 3072;  // pixels

// Pixels that a picture may have, which is in memory as a whole with its depth and states.
inline constexpr std::uint64_t kMostPicturePixels = std::uint64_t{1} << 30;

// Throws std::invalid_argument for a camera whose picture would have more than kMostPicturePixels.
void check_picture_size(const Camera& camera);

struct Tile {
  std::uint32_t left = 0, top = 0;  // the tile's first pixel in the whole image
  Camera camera;
};

// Covers the image row by row, each tile at most `side` wide and high. Throws std::invalid_argument for a side of 0, a
// bad camera or a picture of more than kMostPicturePixels.
[[nodiscard]] std::vector<Tile> tiles_of(const Camera& camera, std::uint32_t side);

// Like the renderer's functions of these names, for pictures of any size that a camera may have; drawn in one piece
// where `side` and the driver's texture size allow it. Rounding differs from tile to tile as from one camera to
// another: by one level at some pixels, and by a pixel at silhouettes. Throw as those functions do, and
// std::invalid_argument for a side of 0.
[[nodiscard]] Rendering render_tiled(Renderer& renderer, const Camera& camera, const BlendOptions& options,
                                     std::uint32_t side = kTileSide);
[[nodiscard]] LinearRendering render_linear_tiled(Renderer& renderer, const Camera& camera, const BlendOptions& options,
                                                  std::uint32_t side = kTileSide);
[[nodiscard]] Diagnosis diagnose_tiled(Renderer& renderer, const Camera& camera, const BlendOptions& options,
                                       std::uint32_t side = kTileSide);

}  // namespace lumatlas
