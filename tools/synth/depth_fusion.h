// SPDX-License-Identifier: GPL-3.0-or-later
// A surface from depth images: they are averaged in a truncated signed distance volume (Curless, Levoy, "A volumetric
// method for building complex models from range images", 1996) that exists near what was measured alone (Niessner et
// al., "Real-time 3D reconstruction at scale using voxel hashing", 2013), and its zero set is cut out by surface nets
// (Gibson, "Constrained elastic surface nets", 1998).
//
// It is our own, because CGAL's meshers of implicit surfaces take functions that are known everywhere: they close what
// no image has seen, and the holes of a scan are what it is wanted for here.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mesh/camera.h"
#include "mesh/mesh.h"

namespace lumatlas {

struct DepthImage {
  Camera camera;
  std::vector<float> depth;  // z in the camera frame at the middle of each pixel, row by row; 0: not measured
};

struct FusionOptions {
  double voxel = 0.02;       // scene units, > 0
  double truncation = 0.05;  // how far from a measurement it says something, scene units, >= voxel
  // A voxel says something where so many images at distance 1 have seen it; one at distance z counts 1 / z^2, > 0.
  double least_weight = 1;
  // Blocks of 512 voxels, 8 bytes each, >= 1: where the surface takes more, the voxels are made larger until it does
  // not.
  std::size_t max_blocks = std::size_t{1} << 18U;  // 1 GiB
};

// Two triangles for each edge of the grid that the surface crosses between voxels that were seen; none without depths.
// Faces look to where the cameras were. The mesh may be non-manifold where two sheets meet in one voxel: see
// mesh/repair.h. The same for any number of threads.
// Throws std::invalid_argument naming the field, its value and the rule that it breaks, an image of the wrong size,
// or a depth too far from the origin, more than 8 million voxels.
[[nodiscard]] TriangleSoup fused(std::span<const DepthImage> images, const FusionOptions& options);

}  // namespace lumatlas
