// SPDX-License-Identifier: GPL-3.0-or-later
// A surface that grows with the depth frames of a stream. Each version keeps the faces, and so the cells, of what has
// hardly changed since the one before. Erat et al. 2019, section 5, ask for it.
//
// Every version is made whole: cut out of all voxels, repaired and divided into cells. The time of a version grows with
// the scene therefore, and tools/live/README.md has measurements.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "atlas/surface.h"
#include "mesh/visibility/visibility.h"
#include "tools/meshing/depth/growing_fusion.h"

namespace lumatlas {

struct LiveSurfaceOptions {
  // Side of a voxel, scene units, > 0. None: kLiveVoxelPixels of the first depth frame at its median depth.
  std::optional<double> voxel;
  double cell_size = 0;  // see CellOptions::size, >= 0; 0: 1/16 of the first frame's median depth
  // Largest number of blocks of the volume, >= 1; a block has 512 voxels and takes 8 KiB. Depth frames that would need
  // more blocks are refused.
  std::size_t max_blocks = std::size_t{1} << 16U;
  glm::dvec3 offset{0};  // that was subtracted from all coordinates, see Surface::offset
};

// A surface of voxels as small as a depth image's pixels has far more faces than can follow a stream.
inline constexpr double kLiveVoxelPixels = 6;

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const LiveSurfaceOptions& options);

// A version of the surface, and what became of the cells of the version before: see CellGrowth.
struct GrownSurface {
  std::shared_ptr<const Surface> surface;
  std::shared_ptr<const Visibility> visibility;
  std::vector<CellId> previous_cell;
  std::vector<std::uint8_t> changed;
};

class LiveSurface {
 public:
  // Throws as check() does.
  explicit LiveSurface(const LiveSurfaceOptions& options);
  ~LiveSurface();
  LiveSurface(const LiveSurface&) = delete;
  LiveSurface& operator=(const LiveSurface&) = delete;

  // Returns false, and takes nothing of the frame, if it measured nothing or there is no room for it. Throws
  // std::invalid_argument as GrowingFusion::add().
  bool add(const DepthImage& image);
  // Returns the next version; none as long as the frames make no surface.
  [[nodiscard]] std::optional<GrownSurface> grow(GrowingFusion::Show show = GrowingFusion::Show::what_changed);
  // Returns the median depth of the first frame, scene units; 0 before it.
  [[nodiscard]] double usual_distance() const { return usual_distance_; }

 private:
  void start(const DepthImage& image);

  LiveSurfaceOptions options_;
  std::unique_ptr<GrowingFusion> fusion_;  // null before the first frame
  double usual_distance_ = 0;
  std::shared_ptr<const Surface> last_;
};

}  // namespace lumatlas
