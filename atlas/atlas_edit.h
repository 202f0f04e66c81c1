// SPDX-License-Identifier: GPL-3.0-or-later
// Several changes of an Atlas that are made at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <variant>
#include <vector>

#include "atlas/tiles/tiles.h"
#include "atlas/views/stored_view.h"
#include "mesh/base/id.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// Lists changes for Atlas::commit(), which makes them in this order. Each method adds the change that the method of the
// same name in Atlas makes, with its units and errors; commit() is what checks and throws. The caller chooses the view
// slots, because other changes of the edit may name them.
//
//   AtlasEdit edit;
//   edit.set_references(cell, {newer});
//   edit.erase(older);
//   edit.insert_at(older, view, shown);
//   atlas.commit(std::move(edit));  // no snapshot has the one without the other
class AtlasEdit {
 public:
  void insert_at(ViewSlot slot, StoredView view, std::vector<ShownCell> shown = {});
  void replace(ViewSlot slot, StoredView view, std::vector<ShownCell> shown = {});
  void erase(ViewSlot slot);
  void set_gain(ViewSlot slot, const glm::dvec3& gain);
  void set_references(CellId cell, std::vector<ViewSlot> slots);
  void mark_seen(std::span<const CellPixels> cells);

  [[nodiscard]] bool empty() const { return changes_.empty(); }

 private:
  friend class Atlas;

  // A change that Atlas applies. Once applied it holds the state before, so that applying it again undoes it.
  struct ViewChange {
    enum class Kind { insert, replace, erase } kind;
    ViewSlot slot;
    std::shared_ptr<const StoredView> view;                 // null: erase
    std::shared_ptr<const std::vector<ShownCell>> shown{};  // null: erase
    glm::dvec3 gain{1.0};                                   // erase
    std::uint64_t tenant = 0;                               // insert
  };
  struct GainChange {
    ViewSlot slot;
    glm::dvec3 gain;
  };
  struct ReferencesChange {
    CellId cell;
    std::shared_ptr<const std::vector<ViewSlot>> slots;
  };
  struct SeenChange {
    std::vector<CellId> cells;
    std::size_t new_cells = 0;  // once applied
  };
  using Change = std::variant<ViewChange, GainChange, ReferencesChange, SeenChange>;

  std::vector<Change> changes_;
};

}  // namespace lumatlas
