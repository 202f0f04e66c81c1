// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/fusion_blocks.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

namespace lumatlas {
namespace {

using glm::dvec3;
using glm::ivec3;

// Sorted, each once.
void tidy(std::vector<ivec3>& blocks) {
  std::sort(blocks.begin(), blocks.end(), by_block_key);
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
}

class BlockFinder {
 public:
  BlockFinder(const DepthImage& image, const FusionOptions& options) : image_(image), options_(options) {}

  std::vector<ivec3> find() {
    const Camera& camera = image_.camera;
    const dvec3 center = camera.center();
    for (std::uint32_t y = 0; y < camera.height; ++y) {
      for (std::uint32_t x = 0; x < camera.width; ++x) {
        const double depth = image_.depth[std::size_t{y} * camera.width + x];
        if (depth > 0) add_around(center, camera.ray({x + 0.5, y + 0.5}), depth);
      }
    }
    tidy(blocks_);
    return std::move(blocks_);
  }

 private:
  // `ray` advances the depth by 1.
  void add_around(const dvec3& center, const dvec3& ray, double depth) {
    const double reach = options_.truncation / glm::length(ray);
    const int steps = static_cast<int>(std::ceil(2 * options_.truncation / (0.5 * kBlockSide * options_.voxel)));
    before_.resize(static_cast<std::size_t>(steps) + 1, {ivec3(0), ivec3(-1)});
    for (int step = 0; step <= steps; ++step) {
      const dvec3 point = center + (depth - reach + 2 * reach * step / steps) * ray;
      const double block = kBlockSide * options_.voxel;
      if (!(glm::length(point) < kBlockReach * block)) {
        throw std::invalid_argument("fusion: a depth of " + std::to_string(depth) + " is too far from the origin");
      }
      const ivec3 low(glm::floor((point - options_.voxel) / block));
      const ivec3 high(glm::floor((point + options_.voxel) / block));
      auto& before = before_[static_cast<std::size_t>(step)];
      if (before == std::pair(low, high)) continue;  // mostly: the pixel beside looked at the same blocks
      before = {low, high};
      add_box(low, high);
    }
  }

  void add_box(const ivec3& low, const ivec3& high) {
    ivec3 block;
    for (block.x = low.x; block.x <= high.x; ++block.x) {
      for (block.y = low.y; block.y <= high.y; ++block.y) {
        for (block.z = low.z; block.z <= high.z; ++block.z) blocks_.push_back(block);
      }
    }
    if (blocks_.size() > kUntidy) tidy(blocks_);
  }

  static constexpr std::size_t kUntidy = std::size_t{1} << 20U;  // how many may wait for being sorted
  const DepthImage& image_;
  const FusionOptions& options_;
  std::vector<std::pair<ivec3, ivec3>> before_;  // per step: the boxes of the last pixel
  std::vector<ivec3> blocks_;
};

void require_of_fusion(bool holds, const char* field, double value, const char* rule) {
  if (holds) return;
  std::ostringstream text;
  text << "fusion: " << field << " is " << value << ", must be " << rule;
  throw std::invalid_argument(text.str());
}

}  // namespace

std::uint64_t block_key(const ivec3& block) {
  const auto part = [](int i) { return static_cast<std::uint64_t>(std::int64_t{i} + kBlockReach + 2); };
  return (part(block.x) << 42U) | (part(block.y) << 21U) | part(block.z);
}

bool by_block_key(const ivec3& a, const ivec3& b) {
  return block_key(a) < block_key(b);
}

std::vector<ivec3> blocks_near(const DepthImage& image, const FusionOptions& options) {
  return BlockFinder(image, options).find();
}

void check(const FusionOptions& options) {
  require_of_fusion(std::isfinite(options.voxel) && options.voxel > 0, "voxel", options.voxel, "finite and above 0");
  require_of_fusion(std::isfinite(options.truncation) && options.truncation >= options.voxel, "truncation",
                    options.truncation, "finite and at least a voxel");
  require_of_fusion(std::isfinite(options.least_weight) && options.least_weight > 0, "least_weight",
                    options.least_weight, "finite and above 0");
  require_of_fusion(options.max_blocks >= 1, "max_blocks", 0, "at least 1");
}

void check(const DepthImage& image, std::size_t index) {
  check(image.camera);
  const std::size_t pixels = std::size_t{image.camera.width} * image.camera.height;
  const auto require_count = [&](std::size_t count, const char* what) {
    if (count == pixels) return;
    throw std::invalid_argument("fusion: image " + std::to_string(index) + " has " + std::to_string(count) + " " +
                                what + ", must have " + std::to_string(pixels));
  };
  require_count(image.depth.size(), "depths");
  if (!image.cosine.empty()) require_count(image.cosine.size(), "cosines");
  if (!image.slope.empty()) require_count(image.slope.size(), "slopes");
}

}  // namespace lumatlas
