// SPDX-License-Identifier: GPL-3.0-or-later
// The shares of neighbouring cells in the surface along their borders, so that where they refer to different views the
// picture of one fades into that of the other instead of ending at a line. Absent from the paper, where each pixel
// shows its own cell's picture.
//
//   s_k(v) = max(0, 1 - d_k(v) / W) / sum of the same over all cells     share of cell k at vertex v
//
// d_k(v) is the distance from v along the mesh's edges to the nearest vertex of cell k, 0 for its own; W the width.
// Vertices at one place are one.
// Inside faces shares are interpolated linearly, so they are continuous over the surface. A pixel's colour is the mean
// of the blends of its cells by their shares; with BlendOptions::consistent each share is divided by 1 - w of the
// cell's best view. Weighing the views by the shares instead would be cheaper. But where views enter and leave by small
// differences of their weights, the fade would be over within a pixel.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "atlas/fade_zones.h"
#include "atlas/snapshot.h"

namespace lumatlas {

// `width` is in scene units, finite and >= 0 (std::invalid_argument otherwise). 0: every face is its own cell's. If the
// width is so large that more than 64 cells share a vertex on average, only the 8 nearest cells of each vertex share
// it. Time and memory then grow with the faces, not with the width. The same bytes for the same input.
[[nodiscard]] CellShares share_cells(const Surface& surface, double width);

// Returns for each cell the first one that refers to the same views, in any order: both blend each place alike.
[[nodiscard]] std::vector<std::uint32_t> first_of_same_references(const ReferenceTable& references);

// Shares of the cells that stand for them, with sums where one stands for several: stands_for[cell], one for each cell
// of the surface, fewer throw std::invalid_argument. What is made of a place stays the same if it is the same for all
// that one stands for, and fewer cells need to be asked.
[[nodiscard]] CellShares joined(CellShares shares, std::span<const std::uint32_t> stands_for);

// Returns the shares by which a model is drawn: share_cells() with `border_width` as a share of the cell size, of the
// cells that stand for all that refer to the same views.
[[nodiscard]] CellShares drawn_shares(const Surface& surface, const ReferenceTable& references, double border_width);

}  // namespace lumatlas
