// SPDX-License-Identifier: GPL-3.0-or-later
// Makes a surface from depth images. They are averaged in a truncated signed distance volume (Curless, Levoy, "A
// volumetric method for building complex models from range images", 1996). The volume exists near measured surface
// alone (Niessner et al., "Real-time 3D reconstruction at scale using voxel hashing", 2013). Surface nets extract its
// zero set (Gibson, "Constrained elastic surface nets", 1998).
//
// It is our own, because CGAL's meshers of implicit surfaces take functions that are known everywhere: they close what
// no image has seen, and the holes of a scan are what it is wanted for here.
#pragma once

#include <cstddef>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "mesh/camera/camera.h"
#include "mesh/mesh.h"

namespace lumatlas {

struct DepthImage {
  Camera camera;
  std::vector<float> depth;  // z in the camera frame at the middle of each pixel, row by row; 0: not measured
  // Cosine of the angle between each pixel's ray and the normal of the surface there, [0, 1]. Distances are then taken
  // along the normal, not along the ray: otherwise a surface that is only seen at a slant would be out of the
  // truncation's reach, and full of holes. A slanted pixel counts less, in proportion. Empty: all 1.
  std::vector<float> cosine = {};
  // The growth of the depth from each pixel to the next, to the right and down, from which depths between the middles
  // of pixels are found. Empty: all 0.
  std::vector<glm::vec2> slope = {};
};

// Throws std::invalid_argument naming the image by its index if its camera cannot be or its lists do not have one entry
// for each of the camera's pixels.
void check(const DepthImage& image, std::size_t index = 0);

struct FusionOptions {
  double voxel = 0.02;       // scene units, > 0
  double truncation = 0.05;  // how far from a measurement it says something, scene units, >= voxel
  // A voxel has a value if at least this many images at distance 1 have seen it. An image at distance z counts 1 / z^2,
  // > 0.
  double least_weight = 1;
  // Blocks of 512 voxels, 8 bytes each, >= 1: where the surface takes more, the voxels are made larger until it does
  // not, or it is refused.
  std::size_t max_blocks = std::size_t{1} << 18U;  // 1 GiB
  bool may_enlarge = true;
};

struct FusedSurface {
  TriangleSoup surface;
  double voxel = 0, truncation = 0;  // the values that were used
  std::size_t blocks = 0;
};

// The depth image of an index, in the same frame as all. Called several times for each, from several threads.
using DepthSource = std::function<DepthImage(std::size_t index)>;

// The axes of a voxel grid that is turned away from the axes of a scene. Walls mostly stand along those. Where a wall
// lies in a plane of the grid, noise puts each of its vertices on one or the other side, with slivers of faces between.
[[nodiscard]] glm::dmat3 grid_from_scene();

// Two triangles for each edge of the grid that the surface crosses between voxels that were seen; none without depths.
// Faces look to where the cameras were. The mesh may be non-manifold where two sheets meet in one voxel: see
// mesh/repair/repair.h. The same for any number of threads. Throws std::invalid_argument naming the field, its value
// and the rule that it breaks, an image of the wrong size, or a depth more than 8 million voxels from the origin.
// Throws InputError if max_blocks are too few and voxels may not be enlarged, and passes on the exception of the source
// for the least index.
[[nodiscard]] TriangleSoup fused(std::span<const DepthImage> images, const FusionOptions& options);

// The same of images that are held a few at a time. `progress` is called with the number of images that have been read
// since the last call, each of them twice, or more often where voxels are enlarged; what it throws ends the work.
[[nodiscard]] FusedSurface fused(std::size_t count, const DepthSource& image, const FusionOptions& options,
                                 const std::function<void(std::size_t)>& progress);

// Reads images a few at a time, in parallel, and hands them on in order: use(first, images). Throws what the source
// throws for the least index.
void for_each_depth_image(std::size_t count, const DepthSource& image,
                          const std::function<void(std::size_t first, std::span<const DepthImage>)>& use);

}  // namespace lumatlas
