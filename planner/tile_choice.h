// SPDX-License-Identifier: GPL-3.0-or-later
// Which tiles are worth their place in a texture array that does not hold all: those that together serve the stored
// cameras best.
//
// The stored views are taken for what will be asked for: each cell in each of them, by the pixels that it has there. A
// tile of view v serves a cell b in the direction of view u by
//
//   q(v, u, b) = share * min(1, r_v / r_u) * (lambda k + 1 - lambda)
//   k = max(0, 1 - (1 - cos angle) / (1 - cos width))
//
// with r the pixels per length with which a view sees the cell, the angle between the two views as the cell sees them,
// and `share` the part of the cell's pixels in v that the resident tiles of v hold. Of each (u, b) the three best
// count, each half as much as the one before, as the renderer blends them. lambda = 0.8 and width = 30 degrees; 0.5 to
// 0.95 and 8 to 60 degrees make little difference on fox and a synthetic apartment. What is sought is the most of the
// sum, in four steps:
//
//   1. Whole views, by what each adds to the sum per tile, until one does not fit.
//   2. More whole views, until the tiles are 1.2 times as many as there may be: what gutters take and more.
//   3. Of these, tiles are given up by what the sum loses, the least first, until there are as many as there may be.
//   4. What room is left goes to single tiles, by what they add.
//
// Each step takes, or gives up, what is best at that moment: values are worked out again where they are likely to have
// become better, and at the head of the queue, for most only become worse.
//
// If steps 2 and 3 made the sum less, they are left out, so that it is never less than that of whole views alone. Views
// come before tiles because what agrees from place to place looks better than what is nearest at each, and because the
// parts of one cell in one view add up: single tiles chosen one by one often sum up to less than whole views (tested).
// A tile comes and goes for all cells in it at once: were each cell to choose by itself, neighbours would choose
// different views, every tile be needed for some cell, and the picture a patchwork.
//
// A store that changes does not choose from all each time. What is resident stays, room goes to single tiles as in step
// 4, and then as many tiles as may be exchanged, once each: the resident ones that are missed least for those that add
// most, wherever that makes the sum more. That costs one look at each tile.
//
// In place of "least coverage per texel" for whole views (Erat et al. 2019, section 3.2): all tiles have the same
// texels.
#pragma once

#include "atlas/tiles/tile_policy.h"

namespace lumatlas {

// The policy for an Atlas: at most demand.max_tiles tiles, the same for the same demand. The references of each cell
// become the views whose resident tiles show it, as many of them as it had. Throws std::invalid_argument unless views,
// shown cells and references are of one store and its surface.
[[nodiscard]] TileChoice choose_tiles(const TileDemand& demand);

}  // namespace lumatlas
