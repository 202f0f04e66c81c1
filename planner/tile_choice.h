// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses the tiles for a texture array that does not hold all: those that together serve the stored cameras best.
//
// Pictures are expected where the stored views are: each cell in each view counts by the pixels that it has there. A
// tile of view v serves a cell b in the direction of view u by
//
//   q(v, u, b) = share * min(1, r_v / r_u) * (lambda k + 1 - lambda)
//   k = max(0, 1 - (1 - cos angle) / (1 - cos width))
//
// with r the pixels per length with which a view sees the cell, the angle between the two views as the cell sees them,
// and `share` the part of the cell's pixels in v that the resident tiles of v hold. For each (u, b) the three best
// count, each half as much as the one before, as the renderer blends them. lambda = 0.8 and width = 30 degrees; 0.5 to
// 0.95 and 8 to 60 degrees make little difference on fox and a synthetic apartment. Four steps seek the largest sum:
//
//   1. Whole views, by what each adds to the sum per tile, until one does not fit.
//   2. More whole views, until the tiles are 1.2 times the limit.
//   3. Tiles of these views are given up by the loss of the sum, the least first, until they are within the limit.
//   4. Free tile places go to single tiles, by what they add.
//
// Each step takes, or gives up, the best candidate at that moment. Most values only become worse, so they are computed
// again only at the head of the queue, and where they are likely to have become better.
//
// Steps 2 and 3 are left out if they made the sum less, so that it is never less than that of whole views alone. Views
// come before tiles because neighbouring tiles of one view agree, which looks better than the nearest view in each
// tile, and because the parts of one cell in one view add up: single tiles chosen one by one often sum up to less than
// whole views (tested). A tile comes and goes for all cells in it at once. If each cell chose by itself, neighbours
// would choose different views, every tile would be needed for some cell, and the picture would be a patchwork.
//
// A store that changes does not start anew each time. Resident tiles stay, free places go to single tiles as in step 4,
// and then tiles are exchanged, up to a limit and each once: the resident ones whose loss costs least for those that
// add most, wherever that makes the sum larger. That looks at each tile once.
//
// It replaces "least coverage per texel" for whole views (Erat et al. 2019, section 3.2), because all tiles have the
// same number of texels.
#pragma once

#include "atlas/tiles/tile_policy.h"

namespace lumatlas {

// The policy for an Atlas: at most demand.max_tiles tiles, the same for the same demand. The references of each cell
// become the views whose resident tiles show it, as many of them as it had. Throws std::invalid_argument unless views,
// shown cells and references are of one store and its surface.
[[nodiscard]] TileChoice choose_tiles(const TileDemand& demand);

}  // namespace lumatlas
