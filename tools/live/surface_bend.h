// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/live/: bends a surface after the frames that it was made of have moved. That takes a part of the
// time in which the frames are fused again, and keeps faces and cells. A place moves with the frames that have measured
// it, so that two walls that a drift has left beside each other move apart from each other.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "mesh/camera/camera.h"
#include "mesh/cells/cells.h"
#include "mesh/mesh.h"
#include "tools/live/kept_depths.h"

namespace lumatlas {

// A small copy of a depth image: of each of its pixels, what the image has in the middle of it.
struct DepthGlance {
  std::uint32_t width = 0, height = 0;  // pixels
  RoundedDepth depth;
};
// Returns a copy whose longer side has at most 48 pixels.
[[nodiscard]] DepthGlance depth_glance(const Camera& camera, const RoundedDepth& depth);

// Says where a frame is, and where it should be.
struct BendingFrame {
  Camera shown;   // as the surface has it, of the depth image's size
  Camera wanted;  // only its pose counts
  const DepthGlance* glance = nullptr;
};

// Returns mesh.positions, each moved by the mean of the rigid motions of the frames that measured its cell or the cells
// around it, by their distances from it. A frame has measured a cell if its depth there is within `reach` of the
// cell's, scene units; near frames count more, by the square of their depth. Cells that no frame has measured move as
// their neighbours do, and stay if none of those moves. A vertex that would move by less than `least` stays, to the
// bit. The same bytes for any number of threads. `cells` must be those of the mesh. A position may not be finite where
// a motion is as large.
[[nodiscard]] std::vector<glm::vec3> bent_positions(const Mesh& mesh, const Cells& cells,
                                                    std::span<const BendingFrame> frames, double reach, double least);

}  // namespace lumatlas
