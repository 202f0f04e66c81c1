// SPDX-License-Identifier: GPL-3.0-or-later
// Views that come and go at random, for tests of what must hold of a store at every step.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {

// Uniform in [0, end); end >= 1.
inline std::uint32_t below(std::uint32_t end, std::mt19937& random) {
  return std::uniform_int_distribution<std::uint32_t>(0, end - 1)(random);
}

// Offers views at random and drops others, as a planner would.
struct RandomStream {
  explicit RandomStream(const TileOptions& layout, TilePolicy policy = {})
      : surface(wall_and_panel(9)),
        visibility(make_ray_visibility(surface->mesh)),
        atlas(surface, 6, layout, std::move(policy)) {}

  void step(std::mt19937& random) {
    if (atlas.size() == atlas.capacity() || (atlas.size() > 0 && below(3, random) == 0))
      drop(ViewSlot(below(6, random)));
    std::uniform_real_distribution<double> place(-0.4, 0.4);
    const Camera camera = oblique_camera(33 + below(20, random), 30 + below(20, random), place(random),
                                         {place(random), place(random), place(random)});
    TiledView tiled = make_tiled_view("view", camera, position_photograph(camera.width, camera.height),
                                      visibility->trace(camera), surface->cells, atlas.layout(), {});
    const ViewSlot slot = atlas.insert(std::move(tiled.view), std::move(tiled.shown));
    for (CellId cell{0}; cell < 9; ++cell) {
      std::vector<ViewSlot> slots = atlas.references(cell);
      if (below(2, random) == 0) slots.push_back(slot);
      atlas.set_references(cell, slots);
    }
  }

  void drop(ViewSlot slot) {
    if (!atlas.view(slot)) return drop(ViewSlot((slot + 1) % 6));
    for (CellId cell{0}; cell < 9; ++cell) {
      std::vector<ViewSlot> slots = atlas.references(cell);
      std::erase(slots, slot);
      atlas.set_references(cell, slots);
    }
    atlas.erase(slot);
  }

  std::shared_ptr<const Surface> surface;
  std::unique_ptr<Visibility> visibility;
  Atlas atlas;
};

}  // namespace lumatlas
