// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/depth_fusion.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <iterator>
#include <numeric>
#include <string>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/meshing/depth/block_update.h"
#include "tools/meshing/depth/surface_nets.h"
#include "tools/meshing/length_text.h"

namespace lumatlas {
namespace {

using glm::ivec3;

void add_blocks_near(std::span<const DepthImage> images, const FusionOptions& options, std::vector<ivec3>& blocks) {
  std::vector<std::vector<ivec3>> of_image(images.size());
  tbb::parallel_for(std::size_t{0}, images.size(),
                    [&](std::size_t i) { of_image[i] = blocks_near(images[i], options); });
  for (const std::vector<ivec3>& more : of_image) {
    std::vector<ivec3> both;
    std::set_union(blocks.begin(), blocks.end(), more.begin(), more.end(), std::back_inserter(both), by_block_key);
    blocks = std::move(both);
  }
}

// The blocks near what was measured, none of the images being kept. Ends soon once there are far too many.
std::vector<ivec3> blocks_near(std::size_t count, const DepthSource& image, const FusionOptions& options,
                               const std::function<void(std::size_t)>& progress) {
  constexpr std::size_t kFarTooMany = 4;  // times as many as there may be
  std::vector<ivec3> blocks;
  for_each_depth_image(count, image, [&](std::size_t, std::span<const DepthImage> images) {
    if (blocks.size() / kFarTooMany > options.max_blocks) return;
    add_blocks_near(images, options, blocks);
    progress(images.size());
  });
  return blocks;
}

// Twice as large voxels take a quarter of the blocks; at least a quarter larger, since that is only roughly so.
double enlargement(std::size_t blocks, std::size_t most) {
  return std::max(1.25, 0.9 * std::sqrt(static_cast<double>(blocks) / static_cast<double>(most)));
}

[[noreturn]] void refuse_blocks(std::size_t blocks, const FusionOptions& options) {
  const auto mebibytes = [](std::size_t of) {
    return std::to_string(of * kBlockVoxels * sizeof(Voxel) >> 20U) + " MiB";
  };
  throw InputError("voxels of " + length_text(options.voxel) + " would take " + mebibytes(blocks) +
                   " or more, at most " + mebibytes(options.max_blocks) + " may be: voxels of " +
                   length_text(options.voxel * enlargement(blocks, options.max_blocks)) + " take about so much");
}

}  // namespace

glm::dmat3 grid_from_scene() {
  return glm::mat3_cast(glm::normalize(glm::dquat(0.8, 0.3, -0.4, 0.33)));
}

void for_each_depth_image(std::size_t count, const DepthSource& image,
                          const std::function<void(std::size_t first, std::span<const DepthImage>)>& use) {
  constexpr std::size_t kAtOnce = 16;
  for (std::size_t first = 0; first < count; first += kAtOnce) {
    std::vector<DepthImage> images(std::min(kAtOnce, count - first));
    std::vector<std::exception_ptr> failures(images.size());
    tbb::parallel_for(std::size_t{0}, images.size(), [&](std::size_t i) {
      try {
        images[i] = image(first + i);
        check(images[i], first + i);
      } catch (...) {
        failures[i] = std::current_exception();
      }
    });
    for (const std::exception_ptr& failure : failures) {
      if (failure) std::rethrow_exception(failure);
    }
    use(first, images);
  }
}

FusedSurface fused(std::size_t count, const DepthSource& image, const FusionOptions& options,
                   const std::function<void(std::size_t)>& progress) {
  check(options);
  FusionOptions fitting = options;
  std::vector<ivec3> blocks = blocks_near(count, image, fitting, progress);
  while (blocks.size() > fitting.max_blocks) {
    if (!options.may_enlarge) refuse_blocks(blocks.size(), fitting);
    fitting.voxel *= enlargement(blocks.size(), fitting.max_blocks);
    fitting.truncation = std::max(options.truncation / options.voxel * fitting.voxel, fitting.voxel);
    blocks = blocks_near(count, image, fitting, progress);
  }
  FusedSurface result{{}, fitting.voxel, fitting.truncation, blocks.size()};
  BlockIndex index;
  for (const ivec3& block : blocks) index.add(block);
  std::vector<Voxels> voxels(index.size());
  for_each_depth_image(count, image, [&](std::size_t, std::span<const DepthImage> images) {
    tbb::parallel_for(std::size_t{0}, index.size(), [&](std::size_t i) {
      for (const DepthImage& depth : images) {
        BlockUpdate(depth, fitting).visit(index[i], [&](std::size_t voxel, double weight, double distance) {
          voxels[i][voxel].sum += static_cast<float>(weight * distance);
          voxels[i][voxel].weight += static_cast<float>(weight);
        });
      }
    });
    progress(images.size());
  });
  std::vector<std::uint32_t> order(index.size());
  std::iota(order.begin(), order.end(), 0U);
  result.surface = surface_of(index, voxels, order, fitting);
  return result;
}

TriangleSoup fused(std::span<const DepthImage> images, const FusionOptions& options) {
  return fused(
             images.size(), [&](std::size_t i) { return images[i]; }, options, [](std::size_t) {})
      .surface;
}

}  // namespace lumatlas
