// SPDX-License-Identifier: GPL-3.0-or-later
// Lists for each cell the stored views that it refers to.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/base/id.h"

namespace lumatlas {

// Cell k refers to the view slots views[offsets[k]] up to views[offsets[k + 1]].
struct ReferenceTable {
  std::vector<std::uint32_t> offsets{0};  // one more than there are cells
  std::vector<ViewSlot> views;            // view slots of the store

  // `cell` must be below the number of cells; this is not checked.
  [[nodiscard]] std::span<const ViewSlot> of_cell(std::size_t cell) const {
    return std::span(views).subspan(offsets[cell], offsets[cell + 1] - offsets[cell]);
  }
};

}  // namespace lumatlas
