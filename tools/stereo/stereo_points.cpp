// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/stereo_points.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace lumatlas {
namespace {

// The squares of one photograph, and which of them have a point already.
class Blocks {
 public:
  Blocks(const Camera& camera, std::uint32_t block_px)
      : camera_(camera),
        block_px_(block_px),
        columns_((camera.width + block_px - 1) / block_px),
        rows_((camera.height + block_px - 1) / block_px),
        taken_(std::size_t{columns_} * rows_, false) {}

  [[nodiscard]] const Camera& camera() const { return camera_; }
  [[nodiscard]] std::uint32_t columns() const { return columns_; }
  [[nodiscard]] std::uint32_t rows() const { return rows_; }
  [[nodiscard]] bool is_taken(std::uint32_t column, std::uint32_t row) const {
    return taken_[std::size_t{row} * columns_ + column];
  }

  void take(const glm::dvec3& point) {
    const glm::dvec3 cam = camera_.cam_from_world(point);
    if (!(cam.z > 0)) return;
    const glm::dvec2 at = camera_.image_from_cam(cam);
    if (!(at.x >= 0 && at.y >= 0 && at.x < camera_.width && at.y < camera_.height)) return;
    const auto column = static_cast<std::uint32_t>(at.x) / block_px_,
               row = static_cast<std::uint32_t>(at.y) / block_px_;
    taken_[std::size_t{row} * columns_ + column] = true;
  }

 private:
  Camera camera_;
  std::uint32_t block_px_, columns_, rows_;
  std::vector<bool> taken_;
};

// The pixel of the square whose depth the most photographs confirm, of these the surest; none has one: nothing.
std::optional<std::size_t> surest_pixel(const StereoDepth& depth, std::uint32_t column, std::uint32_t row,
                                        std::uint32_t block_px) {
  std::optional<std::size_t> best;
  int best_count = 0;
  const std::uint32_t last_x = std::min(depth.camera.width, (column + 1) * block_px);
  const std::uint32_t last_y = std::min(depth.camera.height, (row + 1) * block_px);
  for (std::uint32_t y = row * block_px; y < last_y; ++y) {
    for (std::uint32_t x = column * block_px; x < last_x; ++x) {
      const std::size_t pixel = std::size_t{y} * depth.camera.width + x;
      if (!(depth.depth[pixel] > 0)) continue;
      const int count = __builtin_popcount(depth.agreeing[pixel]);
      if (best && (count < best_count || (count == best_count && !(depth.deviation[pixel] < depth.deviation[*best])))) {
        continue;
      }
      best = pixel;
      best_count = count;
    }
  }
  return best;
}

}  // namespace

StereoPoints stereo_points(const SceneStereo& stereo, std::uint32_t block_px,
                           const std::function<void(std::size_t)>& progress) {
  std::vector<Blocks> blocks;
  for (std::size_t view = 0; view < stereo.views().size(); ++view) blocks.emplace_back(stereo.camera(view), block_px);
  StereoPoints points;
  for (std::size_t view = 0; view < blocks.size(); ++view) {
    const StereoDepth depth = stereo.depth(view);
    const Camera& camera = depth.camera;
    for (std::uint32_t row = 0; row < blocks[view].rows(); ++row) {
      for (std::uint32_t column = 0; column < blocks[view].columns(); ++column) {
        if (blocks[view].is_taken(column, row)) continue;
        const std::optional<std::size_t> pixel = surest_pixel(depth, column, row, block_px);
        if (!pixel) continue;
        const std::size_t x = *pixel % camera.width, y = *pixel / camera.width;
        const glm::dvec2 middle(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
        const glm::dvec3 position = camera.center() + double{depth.depth[*pixel]} * camera.ray(middle);
        std::vector<std::uint32_t> seen_by{static_cast<std::uint32_t>(view)};
        for (std::size_t i = 0; i < stereo.confirming(view).size(); ++i) {
          if ((depth.agreeing[*pixel] >> i & 1U) == 0) continue;
          const std::size_t other = stereo.confirming(view)[i];
          seen_by.push_back(static_cast<std::uint32_t>(other));
          blocks[other].take(position);
        }
        std::sort(seen_by.begin(), seen_by.end());
        points.positions.push_back(position);
        points.deviations.push_back(depth.deviation[*pixel]);
        points.views.push_back(std::move(seen_by));
      }
    }
    progress(1);
  }
  return points;
}

}  // namespace lumatlas
