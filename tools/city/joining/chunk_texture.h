// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/city/: the base texture of one chunk, baked from the photographs that its cells refer to.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "atlas/base_texture.h"
#include "atlas/snapshot.h"

namespace lumatlas {

// Returns what a model would be that has these near cells alone: their faces in their order, and the views that the
// cells refer to. `cells` ascend. Cells, vertices and view slots are numbered anew.
[[nodiscard]] Snapshot snapshot_of_cells(const Snapshot& snapshot, const std::vector<CellId>& cells);

// Returns the texture (baked_texture.h) of these cells' faces, or null where their charts do not fit. Throws
// what else bake_texture() throws.
[[nodiscard]] std::shared_ptr<const BaseTexture> chunk_texture(const Snapshot& snapshot,
                                                               const std::vector<CellId>& cells,
                                                               std::uint32_t most_side_px);

}  // namespace lumatlas
