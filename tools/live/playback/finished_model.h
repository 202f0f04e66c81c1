// SPDX-License-Identifier: GPL-3.0-or-later
// The last step of a stream: the model is made anew, at rest, of the frames that came. While a stream runs, its surface
// has coarse voxels and its views are chosen from those that came before. At rest, neither has to be so.
#pragma once

#include <filesystem>
#include <memory>

#include "atlas/surface.h"
#include "tools/base/progress.h"
#include "tools/pipeline/build_model.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// The frames of a stream, on disk.
struct StreamedFrames {
  SceneViews scene;                  // in its own coordinates, with the last poses; depths of all frames that have them
  std::vector<std::size_t> offered;  // ranks of scene.views, in the order in which they came
  // The surface that pieces were joined to, where no frame has depths; else null.
  std::shared_ptr<const Surface> surface;
};

struct FinishedModel {
  BuildResult result;      // as build_model() returns it
  double voxel = 0;        // side of a voxel of the new surface, scene units; 0: the surface was given
  double fusing_ms = 0;    // wall time of the new surface
  double building_ms = 0;  // and of the views on it
};

// Fuses the depth images in the voxels that `lumatlas mesh` takes, or takes the given surface. Then it builds as
// `lumatlas build --mesh-as-given` does.
// A depth image that cannot be read is left out. Throws InputError as mesh_from_depths() and build_model() do, and what
// the callbacks throw.
[[nodiscard]] FinishedModel finished_model(StreamedFrames frames, const BuildOptions& options,
                                           const StageProgress& fusing, const BuildCallback& building);

}  // namespace lumatlas
