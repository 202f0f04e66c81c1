// SPDX-License-Identifier: GPL-3.0-or-later
// A SLAM system's use of the planner: one triangle, one view, no GL.
#include <cstdio>
#include <memory>

#include "planner/planner.h"

int main() {
  using namespace lumatlas;
  const auto surface = std::make_shared<Surface>();
  surface->mesh.positions = {{-1, -1, 2}, {1, -1, 2}, {0, 1, 2}};
  surface->mesh.faces = {{0, 1, 2}};
  CellOptions cells;
  cells.size = 2;
  surface->cells = make_cells(surface->mesh, cells);
  const auto visibility = make_ray_visibility(surface->mesh);
  Atlas atlas(surface, 4);
  PlannerOptions options;
  options.coverage.ideal_distance = 2;
  Planner planner(atlas, *visibility, options);
  Camera camera;
  camera.width = camera.height = 64;
  camera.fx = camera.fy = 60;
  camera.cx = camera.cy = 32;
  Photograph photograph;
  photograph.width = photograph.height = 64;
  photograph.rgb.assign(3 * 64 * 64, 100);
  const Verdict verdict = planner.offer("only", camera, photograph);
  std::printf("%u cells seen\n", verdict.cells_seen);
  return verdict.decision == Decision::kept && atlas.size() == 1 ? 0 : 1;
}
