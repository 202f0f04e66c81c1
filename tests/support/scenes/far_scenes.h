// SPDX-License-Identifier: GPL-3.0-or-later
// Small scenes with a far sphere, for tests of the view store, its file and the renderers.
#pragma once

#include <memory>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/far_sphere.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {

// A surface with a whole far sphere of about 12 cells behind it.
inline std::shared_ptr<const Surface> with_sphere_behind(const Surface& near, double radius = 400) {
  FarSphere far;
  far.mesh = far_sphere({{0, 0, 0}, radius}, 0.3);
  far.cells = make_cells(far.mesh, {.size = radius});
  return std::make_shared<const Surface>(with_far_sphere(near, far));
}

// Two views of a wall with a far sphere behind it, each referenced by all cells.
inline Snapshot far_snapshot() {
  const auto surface = with_sphere_behind(*wall_and_panel(5));
  Atlas atlas(surface, 2);
  for (const double aside : {-0.5, 0.5}) {
    const Camera camera = forward_camera(40, 30, {aside, 0, -4});
    atlas.insert(traced_view(*surface, aside < 0 ? "left" : "right", camera, position_photograph(40, 30)));
  }
  std::vector<CellPixels> seen;
  for (CellId cell{0}; cell < surface->cells.cells.size(); ++cell) {
    atlas.set_references(cell, {0, 1});
    seen.push_back({CellId{cell}, 1});
  }
  atlas.mark_seen(seen);
  return atlas.snapshot();
}

}  // namespace lumatlas
