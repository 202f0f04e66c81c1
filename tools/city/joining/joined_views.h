// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/city/: the views of several models of parts of one scene as those of one model. A photograph that
// several of them hold becomes one view with the tiles of all.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "atlas/snapshot.h"

namespace lumatlas {

class JoinedViews {
 public:
  // Adds the views of a model, all of whose tiles are cut alike, and returns nothing of it that has no tile. Throws
  // std::invalid_argument for a view that another model has at another pose, or tiles of another size.
  void add(const Snapshot& part);

  // Fills views, gains and tiles of a snapshot, in the order of the names. Call it once: it gives back each view that
  // was added once that is joined.
  void fill(Snapshot& snapshot);
  // Returns the slot in that order of each view slot of a model that was added; ViewSlot::none for one that is free.
  [[nodiscard]] std::vector<ViewSlot> slots_of(const Snapshot& part) const;

 private:
  struct Part {
    std::shared_ptr<const StoredView> view;
    std::vector<std::uint8_t> resident;  // one per tile
  };
  struct View {
    glm::dvec3 gain{1.0};
    std::vector<Part> parts;  // at least one
  };
  [[nodiscard]] std::shared_ptr<const StoredView> joined(const View& view) const;
  [[nodiscard]] std::vector<PixelRect> rectangles(const Camera& camera, const std::vector<std::uint8_t>& tiles) const;

  TileOptions layout_ = kWholeViews;  // until a model with views was added
  std::map<std::string, View> views_;
};

}  // namespace lumatlas
