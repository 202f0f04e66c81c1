// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/fusion_blocks.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <sstream>
#include <stdexcept>
#include <string>

namespace lumatlas {
namespace {

using glm::dvec3;
using glm::ivec3;

constexpr unsigned kKeyBits = 21;  // of a coordinate
constexpr int kKeyShift = kBlockReach + 2;

ivec3 block_of_key(std::uint64_t key) {
  const auto part = [&](unsigned shift) {
    return static_cast<int>((key >> shift) & ((std::uint64_t{1} << kKeyBits) - 1)) - kKeyShift;
  };
  return {part(2 * kKeyBits), part(kKeyBits), part(0)};
}

class BlockFinder {
 public:
  BlockFinder(const DepthImage& image, const FusionOptions& options) : image_(image), options_(options) {}

  std::vector<ivec3> find() {
    const Camera& camera = image_.camera;
    const dvec3 center = camera.center();
    const int steps = static_cast<int>(std::ceil(2 * options_.truncation / (0.5 * kBlockSide * options_.voxel)));
    last_.resize(static_cast<std::size_t>(steps) + 1);
    for (std::uint32_t y = 0; y < camera.height; ++y) {
      for (std::uint32_t x = 0; x < camera.width; ++x) {
        const double depth = image_.depth[std::size_t{y} * camera.width + x];
        if (depth > 0) add_around(center, camera.ray({x + 0.5, y + 0.5}), depth);
      }
    }
    tidy();
    std::vector<ivec3> blocks;
    blocks.reserve(keys_.size());
    for (const std::uint64_t key : keys_) blocks.push_back(block_of_key(key));
    return blocks;
  }

 private:
  // Points from `low` to below `high`, component by component, need the same blocks.
  struct Neighbourhood {
    dvec3 low{1.0}, high{-1.0};
    [[nodiscard]] bool contains(const dvec3& p) const {
      return p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x < high.x && p.y < high.y && p.z < high.z;
    }
  };

  // `ray` advances the depth by 1.
  void add_around(const dvec3& center, const dvec3& ray, double depth) {
    const double reach = options_.truncation / glm::length(ray);
    const auto steps = static_cast<double>(last_.size() - 1);
    for (std::size_t step = 0; step < last_.size(); ++step) {
      const dvec3 point = center + (depth - reach + 2 * reach * static_cast<double>(step) / steps) * ray;
      if (last_[step].contains(point)) continue;  // mostly: the pixel beside needed the same blocks
      add_near(point, depth, last_[step]);
    }
  }

  void add_near(const dvec3& point, double depth, Neighbourhood& same) {
    const double block = kBlockSide * options_.voxel;
    if (!(glm::length(point) < kBlockReach * block)) {
      throw std::invalid_argument("fusion: a depth of " + std::to_string(depth) + " is too far from the origin");
    }
    const ivec3 low(glm::floor((point - options_.voxel) / block));
    const ivec3 high(glm::floor((point + options_.voxel) / block));
    add_box(low, high);
    for (int axis = 0; axis < 3; ++axis) {
      same.low[axis] = std::max(low[axis] * block + options_.voxel, high[axis] * block - options_.voxel);
      same.high[axis] = std::min((low[axis] + 1) * block + options_.voxel, (high[axis] + 1) * block - options_.voxel);
    }
  }

  void add_box(const ivec3& low, const ivec3& high) {
    ivec3 block;
    for (block.x = low.x; block.x <= high.x; ++block.x) {
      for (block.y = low.y; block.y <= high.y; ++block.y) {
        for (block.z = low.z; block.z <= high.z; ++block.z) add(block_key(block));
      }
    }
  }

  // Neighbouring rows need the same blocks, so that most keys are among those that were added last.
  void add(std::uint64_t key) {
    std::uint64_t& recent = recent_[(key * 0x9E3779B97F4A7C15U) >> (64U - kRecentBits)];
    if (recent == key) return;
    recent = key;
    keys_.push_back(key);
    if (keys_.size() <= untidy_) return;
    tidy();
    untidy_ = std::max(kUntidy, 2 * keys_.size());  // so that many blocks are not sorted for every key
  }

  // Sorted, each once.
  void tidy() {
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  }

  static constexpr std::size_t kUntidy = std::size_t{1} << 20U;
  static constexpr unsigned kRecentBits = 12;
  const DepthImage& image_;
  const FusionOptions& options_;
  std::vector<Neighbourhood> last_;  // by step: of the last pixel that left the one before
  std::vector<std::uint64_t> keys_;
  std::size_t untidy_ = kUntidy;  // how many keys may be there before they are sorted
  std::vector<std::uint64_t> recent_ = std::vector<std::uint64_t>(std::size_t{1} << kRecentBits, 0);  // no block is 0
};

void require_of_fusion(bool holds, const char* field, double value, const char* rule) {
  if (holds) return;
  std::ostringstream text;
  text << "fusion: " << field << " is " << value << ", must be " << rule;
  throw std::invalid_argument(text.str());
}

}  // namespace

std::uint64_t block_key(const ivec3& block) {
  const auto part = [](int i) { return static_cast<std::uint64_t>(std::int64_t{i} + kKeyShift); };
  return (part(block.x) << (2 * kKeyBits)) | (part(block.y) << kKeyBits) | part(block.z);
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
