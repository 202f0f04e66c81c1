// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/depth_fusion.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <iterator>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/meshing/length_text.h"

namespace lumatlas {
namespace {

using glm::dvec3;
using glm::ivec3;

constexpr int kSide = 8;  // voxels along a block's edge
constexpr std::size_t kVoxels = std::size_t{kSide} * kSide * kSide;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

struct Voxel {
  float sum = 0;  // sum of weight times distance, in units of the truncation, in [-1, 1]; positive in the open
  float weight = 0;
};
using Voxels = std::array<Voxel, kVoxels>;

std::size_t index_in_block(const ivec3& v) {  // takes v in [0, kSide)^3
  return static_cast<std::size_t>((v.z * kSide + v.y) * kSide + v.x);
}

constexpr int kReach = (1 << 20) - 2;  // blocks from the origin that measurements are within

// A block's number, ordered like (x, y, z).
std::uint64_t key_of(const ivec3& block) {
  const auto part = [](int i) { return static_cast<std::uint64_t>(i + kReach + 2); };
  return (part(block.x) << 42U) | (part(block.y) << 21U) | part(block.z);
}

ivec3 floor_divided(const ivec3& v) {
  return {v.x >> 3, v.y >> 3, v.z >> 3};
}

bool by_key(const ivec3& a, const ivec3& b) {
  return key_of(a) < key_of(b);
}

// Sorted, each once.
void tidy(std::vector<ivec3>& blocks) {
  std::sort(blocks.begin(), blocks.end(), by_key);
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
}

// Blocks with voxels within the truncation of a measurement, along the rays; one voxel more in all directions, since
// the surface is cut out of cells with eight voxels.
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
    const int steps = static_cast<int>(std::ceil(2 * options_.truncation / (kSide / 2 * options_.voxel)));
    before_.resize(static_cast<std::size_t>(steps) + 1, {ivec3(0), ivec3(-1)});
    for (int step = 0; step <= steps; ++step) {
      const dvec3 point = center + (depth - reach + 2 * reach * step / steps) * ray;
      const double block = kSide * options_.voxel;
      if (!(glm::length(point) < kReach * block)) {
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

void add_blocks_near(std::span<const DepthImage> images, const FusionOptions& options, std::vector<ivec3>& blocks) {
  std::vector<std::vector<ivec3>> of_image(images.size());
  tbb::parallel_for(std::size_t{0}, images.size(),
                    [&](std::size_t i) { of_image[i] = BlockFinder(images[i], options).find(); });
  for (const std::vector<ivec3>& more : of_image) {
    std::vector<ivec3> both;
    std::set_union(blocks.begin(), blocks.end(), more.begin(), more.end(), std::back_inserter(both), by_key);
    blocks = std::move(both);
  }
}

// Voxels behind a surface that are needed to cut it out: a diagonal, and something for noise.
constexpr double kNeeded = 2.5;

// The update of one block's voxels from one image.
class BlockUpdate {
 public:
  BlockUpdate(const DepthImage& image, const FusionOptions& options)
      : image_(image), camera_(image.camera), options_(options) {}

  void add_to(const ivec3& block, Voxels& voxels) const {
    const double voxel = options_.voxel;
    const dvec3 corner = camera_.cam_from_world(kSide * voxel * dvec3(block));
    const glm::dmat3 axes = voxel * camera_.cam_from_world_rotation;
    if (is_out_of_view(corner + 0.5 * kSide * (axes * dvec3(1)), 0.5 * std::sqrt(3.0) * kSide * voxel)) return;
    ivec3 v;
    for (v.z = 0; v.z < kSide; ++v.z) {
      for (v.y = 0; v.y < kSide; ++v.y) {
        for (v.x = 0; v.x < kSide; ++v.x) add_at(corner + axes * dvec3(v), voxels[index_in_block(v)]);
      }
    }
  }

 private:
  // Returns whether a ball in the camera frame is out of view. Balls that reach behind the camera are taken to be in
  // view.
  [[nodiscard]] bool is_out_of_view(const dvec3& middle, double radius) const {
    if (middle.z + radius <= 0) return true;
    const double nearest = middle.z - radius;
    if (nearest <= 0) return false;
    const glm::dvec2 at = camera_.image_from_cam(middle);
    // A point of the ball is off its middle by at most this much in the picture: by the radius across, and by as
    // much along a ray whose slope is that of the middle.
    const double slope = 1 + std::hypot(middle.x, middle.y) / middle.z;
    const double margin = std::max(camera_.fx, camera_.fy) * radius / nearest * slope;
    return at.x + margin < 0 || at.y + margin < 0 || at.x - margin > camera_.width || at.y - margin > camera_.height;
  }

  void add_at(const dvec3& cam, Voxel& voxel) const {
    if (cam.z <= 0) return;
    const glm::dvec2 at = camera_.image_from_cam(cam);
    if (!(at.x >= 0 && at.y >= 0 && at.x < camera_.width && at.y < camera_.height)) return;
    const std::size_t pixel = static_cast<std::size_t>(at.y) * camera_.width + static_cast<std::size_t>(at.x);
    double depth = image_.depth[pixel];
    if (depth <= 0) return;
    if (!image_.slope.empty()) depth += glm::dot(glm::dvec2(image_.slope[pixel]), at - (glm::floor(at) + 0.5));
    if (depth <= 0) return;
    const double cosine = image_.cosine.empty() ? 1.0 : double{image_.cosine[pixel]};
    const double distance = cosine * (depth - cam.z) * glm::length(cam) / cam.z;
    // Along the ray no further than the truncation, or than the eight voxels about a slanted surface need. The space
    // further behind it is unknown.
    if (distance < -std::min(options_.truncation, std::max(cosine * options_.truncation, kNeeded * options_.voxel))) {
      return;
    }
    const double weight = cosine / (depth * depth);
    voxel.sum += static_cast<float>(weight * std::min(1.0, distance / options_.truncation));
    voxel.weight += static_cast<float>(weight);
  }

  const DepthImage& image_;
  const Camera& camera_;
  const FusionOptions& options_;
};

// The blocks that a volume has, by their coordinates.
class BlockIndex {
 public:
  // Adds a block unless it is there, and returns its number.
  std::uint32_t add(const ivec3& block) {
    const auto [entry, added] = number_.emplace(key_of(block), static_cast<std::uint32_t>(blocks_.size()));
    if (added) blocks_.push_back(block);
    return entry->second;
  }
  // Returns kNone if there is no such block.
  [[nodiscard]] std::uint32_t find(const ivec3& block) const {
    const auto found = number_.find(key_of(block));
    return found == number_.end() ? kNone : found->second;
  }
  [[nodiscard]] std::size_t size() const { return blocks_.size(); }
  [[nodiscard]] const ivec3& operator[](std::size_t number) const { return blocks_[number]; }

 private:
  std::vector<ivec3> blocks_;
  std::unordered_map<std::uint64_t, std::uint32_t> number_;
};

// Cuts the surface out of the voxels of blocks.
class SurfaceExtraction {
 public:
  SurfaceExtraction(const BlockIndex& blocks, const std::vector<Voxels>& voxels, const FusionOptions& options)
      : options_(options), blocks_(blocks), voxels_(voxels) {}

  TriangleSoup surface() {
    vertex_of_cell_.assign(blocks_.size() * kVoxels, kNone);
    for (std::uint32_t block = 0; block < blocks_.size(); ++block) add_vertices(block);
    for (std::uint32_t block = 0; block < blocks_.size(); ++block) add_faces(block);
    return std::move(surface_);
  }

 private:
  using Corners = std::array<float, 8>;               // distances at the corners x + 2 y + 4 z of a cell
  using BlocksAround = std::array<std::uint32_t, 8>;  // the block itself and those after it, in the same order

  static ivec3 offset(int corner) { return {corner & 1, (corner >> 1) & 1, corner >> 2}; }

  [[nodiscard]] BlocksAround blocks_around(std::uint32_t block) const {
    BlocksAround around{};
    for (int i = 0; i < 8; ++i) around[static_cast<std::size_t>(i)] = blocks_.find(blocks_[block] + offset(i));
    return around;
  }

  // Returns false if one of the corners was not seen.
  bool read_corners(const BlocksAround& around, const ivec3& cell, Corners& corners) const {
    for (int i = 0; i < 8; ++i) {
      const ivec3 at = cell + offset(i);
      const ivec3 beyond = floor_divided(at);
      const std::uint32_t block = around[static_cast<std::size_t>(beyond.x + 2 * beyond.y + 4 * beyond.z)];
      if (block == kNone) return false;
      const Voxel& voxel = voxels_[block][index_in_block(at - kSide * beyond)];
      if (voxel.weight < options_.least_weight) return false;
      corners[static_cast<std::size_t>(i)] = voxel.sum / voxel.weight;
    }
    return true;
  }

  // In cells, from the cell's first corner: the mean of where the surface crosses the cell's edges; none if it does
  // not.
  static bool find_crossing(const Corners& corners, dvec3& crossing) {
    dvec3 sum(0.0);
    int count = 0;
    for (int from = 0; from < 8; ++from) {
      for (int axis = 0; axis < 3; ++axis) {
        const int to = from | (1 << axis);
        const float a = corners[static_cast<std::size_t>(from)];
        const float b = corners[static_cast<std::size_t>(to)];
        if (to == from || (a < 0) == (b < 0)) continue;
        dvec3 at(offset(from));
        at[axis] = static_cast<double>(a) / (static_cast<double>(a) - b);
        sum += at;
        ++count;
      }
    }
    if (count > 0) crossing = sum / static_cast<double>(count);
    return count > 0;
  }

  template <typename Visit>
  static void for_each_cell(const Visit& visit) {
    ivec3 v;
    for (v.z = 0; v.z < kSide; ++v.z) {
      for (v.y = 0; v.y < kSide; ++v.y) {
        for (v.x = 0; v.x < kSide; ++v.x) visit(v);
      }
    }
  }

  void add_vertices(std::uint32_t block) {
    const BlocksAround around = blocks_around(block);
    for_each_cell([&](const ivec3& cell) {
      Corners corners{};
      dvec3 crossing;
      if (!read_corners(around, cell, corners) || !find_crossing(corners, crossing)) return;
      vertex_of_cell_[block * kVoxels + index_in_block(cell)] = static_cast<std::uint32_t>(surface_.positions.size());
      surface_.positions.push_back(options_.voxel * (dvec3(kSide * blocks_[block] + cell) + crossing));
    });
  }

  // kNone: the surface does not cross that cell, or not all of it was seen.
  [[nodiscard]] std::uint32_t vertex_at(const ivec3& cell) const {
    const ivec3 in = floor_divided(cell);
    const std::uint32_t block = blocks_.find(in);
    return block == kNone ? kNone : vertex_of_cell_[block * kVoxels + index_in_block(cell - kSide * in)];
  }

  [[nodiscard]] bool is_inside(std::uint32_t block, const ivec3& at) const {
    return voxels_[block][index_in_block(at)].sum < 0;
  }

  // A quad for each edge that starts at a cell's first corner and crosses the surface, between the four cells around.
  void add_faces(std::uint32_t block) {
    const BlocksAround around = blocks_around(block);
    for_each_cell([&](const ivec3& cell) {
      if (vertex_of_cell_[block * kVoxels + index_in_block(cell)] == kNone) return;
      const bool inside = is_inside(block, cell);
      for (int axis = 0; axis < 3; ++axis) {
        ivec3 end = cell;
        ++end[axis];
        const ivec3 beyond = floor_divided(end);
        const std::uint32_t other = around[static_cast<std::size_t>(beyond.x + 2 * beyond.y + 4 * beyond.z)];
        if (is_inside(other, end - kSide * beyond) != inside) {
          add_quad(kSide * blocks_[block] + cell, axis, inside);
        }
      }
    });
  }

  // Round the edge along `axis` from the first corner of `cell`; it faces the edge's end if the edge comes from inside.
  void add_quad(const ivec3& cell, int axis, bool from_inside) {
    ivec3 b(0);
    ivec3 c(0);
    b[(axis + 1) % 3] = 1;
    c[(axis + 2) % 3] = 1;
    std::array<std::uint32_t, 4> v{vertex_at(cell), vertex_at(cell - b), vertex_at(cell - b - c), vertex_at(cell - c)};
    if (std::find(v.begin(), v.end(), kNone) != v.end()) return;
    if (!from_inside) std::swap(v[1], v[3]);
    const auto length = [&](std::uint32_t from, std::uint32_t to) {
      return glm::distance(surface_.positions[from], surface_.positions[to]);
    };
    if (length(v[1], v[3]) < length(v[0], v[2])) std::rotate(v.begin(), v.begin() + 1, v.end());
    surface_.faces.emplace_back(v[0], v[1], v[2]);
    surface_.faces.emplace_back(v[0], v[2], v[3]);
  }

  const FusionOptions& options_;
  const BlockIndex& blocks_;
  const std::vector<Voxels>& voxels_;
  std::vector<std::uint32_t> vertex_of_cell_;  // per block and its cells, by their first corners
  TriangleSoup surface_;
};

void require(bool holds, const char* field, double value, const char* rule) {
  if (holds) return;
  std::ostringstream text;
  text << "fusion: " << field << " is " << value << ", must be " << rule;
  throw std::invalid_argument(text.str());
}

void check(const FusionOptions& options) {
  require(std::isfinite(options.voxel) && options.voxel > 0, "voxel", options.voxel, "finite and above 0");
  require(std::isfinite(options.truncation) && options.truncation >= options.voxel, "truncation", options.truncation,
          "finite and at least a voxel");
  require(std::isfinite(options.least_weight) && options.least_weight > 0, "least_weight", options.least_weight,
          "finite and above 0");
  require(options.max_blocks >= 1, "max_blocks", 0, "at least 1");
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
  const auto mebibytes = [](std::size_t of) { return std::to_string(of * kVoxels * sizeof(Voxel) >> 20U) + " MiB"; };
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
      for (const DepthImage& depth : images) BlockUpdate(depth, fitting).add_to(index[i], voxels[i]);
    });
    progress(images.size());
  });
  result.surface = SurfaceExtraction(index, voxels, fitting).surface();
  return result;
}

TriangleSoup fused(std::span<const DepthImage> images, const FusionOptions& options) {
  return fused(
             images.size(), [&](std::size_t i) { return images[i]; }, options, [](std::size_t) {})
      .surface;
}

// A block is shown anew when its voxels have been seen by this share more than when it was shown last: twice as much.
// So a block is shown as often as the logarithm of what is seen of it, and what it would move by is below the noise
// that it was shown with.
constexpr float kShownAnew = 1;

struct GrowingFusion::State {
  explicit State(const FusionOptions& fusion) : options(fusion) {}

  void show(std::uint32_t block) {
    shown[block] = voxels[block];
    shown_weight[block] = weight[block];
  }

  FusionOptions options;
  BlockIndex blocks;
  std::vector<Voxels> voxels, shown;        // of all images, and those that the surface was cut out of last
  std::vector<float> weight, shown_weight;  // sums over the voxels of each block
};

GrowingFusion::GrowingFusion(const FusionOptions& options) {
  check(options);
  state_ = std::make_unique<State>(options);
}

GrowingFusion::~GrowingFusion() = default;

bool GrowingFusion::add(const DepthImage& image) {
  check(image, 0);
  State& state = *state_;
  const std::vector<ivec3> near = BlockFinder(image, state.options).find();
  const auto is_new = [&](const ivec3& block) { return state.blocks.find(block) == kNone; };
  const auto added = static_cast<std::size_t>(std::count_if(near.begin(), near.end(), is_new));
  if (state.blocks.size() + added > state.options.max_blocks) return false;
  std::vector<std::uint32_t> numbers;
  numbers.reserve(near.size());
  for (const ivec3& block : near) numbers.push_back(state.blocks.add(block));
  state.voxels.resize(state.blocks.size());
  state.shown.resize(state.blocks.size());
  state.weight.resize(state.blocks.size(), 0);
  state.shown_weight.resize(state.blocks.size(), 0);
  tbb::parallel_for(std::size_t{0}, numbers.size(), [&](std::size_t i) {
    const std::uint32_t block = numbers[i];
    BlockUpdate(image, state.options).add_to(state.blocks[block], state.voxels[block]);
    float sum = 0;
    for (const Voxel& voxel : state.voxels[block]) sum += voxel.weight;
    state.weight[block] = sum;
  });
  return true;
}

TriangleSoup GrowingFusion::surface(Show what) {
  State& state = *state_;
  for (std::uint32_t block = 0; block < state.blocks.size(); ++block) {
    const float least = what == Show::everything ? 0 : kShownAnew * state.shown_weight[block];
    if (state.weight[block] - state.shown_weight[block] > least) state.show(block);
  }
  return SurfaceExtraction(state.blocks, state.shown, state.options).surface();
}

std::size_t GrowingFusion::blocks() const {
  return state_->blocks.size();
}

}  // namespace lumatlas
