// SPDX-License-Identifier: GPL-3.0-or-later
// The reader of captures alone: what a COLMAP workspace holds, which of its photographs would be held out, and one of
// them as a pinhole camera would have taken it. Usage: consumer SCENE
#include <cstdio>
#include <exception>

#include "tools/scene/scene.h"
#include "tools/surface/surface_input.h"

int main(int argc, char** argv) {
  using namespace lumatlas;
  if (argc < 2) return 2;
  try {
    const SurfaceInput input = load_surface(argv[1], std::nullopt, {});
    const SceneViews scene = read_scene_views(argv[1], input.surface->offset);
    const Split split = split_to_score(scene, HoldOut{.hold = 8});
    const Photograph photograph = load_photograph(scene.views[split.scored[0]]);
    std::printf("%s: %zu cells; %zu photographs to learn from, %zu to score, the first %u x %u\n",
                input.mesh_file.c_str(), input.surface->cells.cells.size(), split.input.size(), split.scored.size(),
                photograph.width, photograph.height);
    return split.input.size() + split.scored.size() == scene.views.size() ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
