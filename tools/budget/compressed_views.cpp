// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/compressed_views.h"

#include <tbb/parallel_for.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

std::vector<SharedShownCells> shown_in(const TileOptions& layout, const Atlas& atlas, const Visibility& visibility) {
  std::vector<SharedShownCells> shown(atlas.capacity(), std::make_shared<const std::vector<ShownCell>>());
  tbb::parallel_for(std::size_t{0}, shown.size(), [&](std::size_t slot) {
    throw_if_interrupted();
    const auto view = atlas.view(ViewSlot(static_cast<std::uint32_t>(slot)));
    if (!view) return;
    const VisibilityBuffer visible = visibility.trace_sparsely(view->camera);
    shown[slot] = std::make_shared<const std::vector<ShownCell>>(
        shown_cells(*view, visible.face, atlas.surface()->cells, layout));
  });
  return shown;
}

}  // namespace

std::optional<MeasuredLoss> compress_views_within(double max_loss_db, double reference_loss_db,
                                                  const TileOptions& compressed, Atlas& atlas, HeldOutLoss& measured,
                                                  const Visibility& visibility) {
  const TileOptions layout_before = atlas.layout();
  const std::vector<SharedShownCells> before = atlas.retile(compressed, shown_in(compressed, atlas, visibility));
  try {
    const MeasuredLoss loss = measured.now({{}, reference_loss_db}, max_loss_db);
    if (loss.at_most_db() <= max_loss_db) return loss;
  } catch (const GlError&) {
    atlas.retile(layout_before, before);
    throw;
  }
  atlas.retile(layout_before, before);
  return std::nullopt;
}

}  // namespace lumatlas
