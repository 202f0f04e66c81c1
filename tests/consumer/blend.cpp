// SPDX-License-Identifier: GPL-3.0-or-later
// A viewer's use of the renderer: an empty model drawn by the reference, and by the GPU where there is one.
#include <cstdio>
#include <memory>

#include "atlas/atlas.h"
#include "blend/gl/egl_context.h"
#include "blend/reference.h"
#include "blend/renderer.h"

int main() {
  using namespace lumatlas;
  const auto surface = std::make_shared<Surface>();
  surface->mesh.positions = {{-1, -1, 2}, {1, -1, 2}, {0, 1, 2}};
  surface->mesh.faces = {{0, 1, 2}};
  CellOptions cells;
  cells.size = 2;
  surface->cells = make_cells(surface->mesh, cells);
  const Snapshot snapshot = Atlas(surface, 1).snapshot();
  Camera camera;
  camera.width = camera.height = 64;
  camera.fx = camera.fy = 60;
  camera.cx = camera.cy = 32;
  const auto visibility = make_ray_visibility(surface->mesh);
  const Rendering reference = render_reference(snapshot, camera, visibility->trace(camera), {});
  if (reference.state[32 * 64 + 32] != PixelState::unseen) return 1;
  try {
    const EglContext context;
    Renderer renderer;
    renderer.load(snapshot);
    return renderer.render(camera, {}).state[32 * 64 + 32] == PixelState::unseen ? 0 : 1;
  } catch (const GlError& error) {
    std::printf("without GL: %s\n", error.what());
    return 0;
  }
}
