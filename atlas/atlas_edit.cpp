// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/atlas_edit.h"

#include <utility>

namespace lumatlas {

void AtlasEdit::insert_at(ViewSlot slot, StoredView view, std::vector<ShownCell> shown) {
  changes_.emplace_back(ViewChange{.kind = ViewChange::Kind::insert,
                                   .slot = slot,
                                   .view = std::make_shared<const StoredView>(std::move(view)),
                                   .shown = std::make_shared<const std::vector<ShownCell>>(std::move(shown))});
}

void AtlasEdit::replace(ViewSlot slot, StoredView view, std::vector<ShownCell> shown) {
  insert_at(slot, std::move(view), std::move(shown));
  std::get<ViewChange>(changes_.back()).kind = ViewChange::Kind::replace;
}

void AtlasEdit::erase(ViewSlot slot) {
  changes_.emplace_back(ViewChange{.kind = ViewChange::Kind::erase, .slot = slot, .view = nullptr});
}

void AtlasEdit::set_gain(ViewSlot slot, const glm::dvec3& gain) {
  changes_.emplace_back(GainChange{slot, gain});
}

void AtlasEdit::set_references(CellId cell, std::vector<ViewSlot> slots) {
  changes_.emplace_back(ReferencesChange{cell, std::make_shared<const std::vector<ViewSlot>>(std::move(slots))});
}

void AtlasEdit::mark_seen(std::span<const CellPixels> cells) {
  SeenChange change;
  change.cells.reserve(cells.size());
  for (const CellPixels& seen : cells) change.cells.push_back(seen.cell);
  changes_.emplace_back(std::move(change));
}

}  // namespace lumatlas
