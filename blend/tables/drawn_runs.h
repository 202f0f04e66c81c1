// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the runs of a ZoneMesh's faces that a camera may see, so that a part of a picture costs the faces
// near it.
#pragma once

#include <array>
#include <vector>

#include "blend/tables/cell_runs.h"
#include "blend/tables/ranked_references.h"
#include "blend/tables/zone_mesh.h"
#include "mesh/camera.h"

namespace lumatlas {

class DrawnRuns {
 public:
  // Ascending runs of faces for each shader, in the order of kCellsOfShader.
  using OfShaders = std::array<std::vector<FaceRun>, kCellsOfShader.size()>;

  DrawnRuns() = default;
  explicit DrawnRuns(const ZoneMesh& mesh);

  // Returns runs with all faces that have a part in the image and in front of the camera, and as few others as a ball
  // around each kFacesOfRun faces can tell.
  [[nodiscard]] OfShaders in_view(const Camera& camera) const;

  static constexpr std::uint32_t kFacesOfRun = 1024;

 private:
  struct Run {
    FaceRun faces;
    Ball ball;
  };
  std::array<std::vector<Run>, kCellsOfShader.size()> runs_;
};

}  // namespace lumatlas
