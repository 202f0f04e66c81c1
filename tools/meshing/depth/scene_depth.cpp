// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/scene_depth.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"

namespace lumatlas {
namespace {

constexpr double kLeastCosine = 0.1;  // cosine of the angle to the normal, 84 degrees

// Sizes that differ by less than a pixel from the same shape are of the same shape.
void check_shape(const GreyImage& image, const SceneDepth& depth) {
  const double across = static_cast<double>(image.width) * depth.lens.height;
  const double down = static_cast<double>(image.height) * depth.lens.width;
  if (std::abs(across - down) < std::max(depth.lens.width, depth.lens.height)) return;
  throw InputError(depth.file.string() + ": is " + size_text(image.width, image.height) +
                   " pixels, which is not the shape of what its camera takes, " +
                   size_text(depth.lens.width, depth.lens.height));
}

// The depth image's pixel, by its index, that each pixel of `camera` looks at; none: the lens does not see that.
class UndistortedPixels {
 public:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  UndistortedPixels(const GreyImage& image, const SceneDepth& depth, const Camera& camera)
      : lens_(depth.lens), camera_(camera), image_size_(image.width, image.height) {
    const double across = std::max(camera.cx, camera.width - camera.cx) / camera.fx;
    const double down = std::max(camera.cy, camera.height - camera.cy) / camera.fy;
    reach_ = reach(lens_, std::hypot(across, down));
  }

  [[nodiscard]] std::size_t at(std::uint32_t x, std::uint32_t y) const {
    const glm::dvec3 direction((x + 0.5 - camera_.cx) / camera_.fx, (y + 0.5 - camera_.cy) / camera_.fy, 1);
    if (std::hypot(direction.x, direction.y) > reach_) return kNone;
    const std::optional<glm::dvec2> seen = image_from_cam(lens_, direction);
    if (!seen) return kNone;
    const glm::dvec2 pixel = glm::floor(*seen / glm::dvec2(lens_.width, lens_.height) * glm::dvec2(image_size_));
    if (!(pixel.x >= 0 && pixel.y >= 0 && pixel.x < image_size_.x && pixel.y < image_size_.y)) return kNone;
    return static_cast<std::size_t>(pixel.y) * image_size_.x + static_cast<std::size_t>(pixel.x);
  }

 private:
  const CameraModel& lens_;
  const Camera& camera_;
  glm::uvec2 image_size_;
  double reach_ = 0;  // radius in the plane z = 1
};

std::vector<float> undistorted_depth(const GreyImage& image, const SceneDepth& depth, const Camera& camera) {
  std::vector<float> result(image.values.size(), 0);
  const bool distorted = is_distorted(depth.lens);
  const UndistortedPixels pixels(image, depth, camera);
  for (std::uint32_t y = 0; y < image.height; ++y) {
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const std::size_t to = std::size_t{y} * image.width + x;
      const std::size_t from = distorted ? pixels.at(x, y) : to;
      if (from != UndistortedPixels::kNone) result[to] = static_cast<float>(depth.unit * image.values[from]);
    }
  }
  return result;
}

// Returns how much the depth grows from a pixel to the next: by the neighbour that differs less, which is on the same
// surface where the other one is beyond an edge. NaN where neither was measured.
double slope(float before, float here, float after) {
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  const double down = before > 0 ? double{here} - before : nothing;
  const double up = after > 0 ? double{after} - here : nothing;
  if (!(before > 0)) return up;
  return after > 0 && std::abs(up) < std::abs(down) ? up : down;
}

// With P = z r the point that a pixel sees, r its ray: the normal is dP/dx x dP/dy.
double cosine(const Camera& camera, const glm::dvec3& ray, double z, double slope_x, double slope_y) {
  const glm::dvec3 along_x = slope_x * ray + glm::dvec3(z / camera.fx, 0, 0);
  const glm::dvec3 along_y = slope_y * ray + glm::dvec3(0, z / camera.fy, 0);
  const glm::dvec3 normal = glm::cross(along_x, along_y);
  return std::abs(glm::dot(normal, ray)) / (glm::length(normal) * glm::length(ray));
}

// Pixels that are seen too much aslant, or have no neighbour, get the cosine 0.
void add_slant(DepthImage& image) {
  const Camera& camera = image.camera;
  const auto depth_at = [&](std::int64_t x, std::int64_t y) {
    if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) return 0.0F;
    return image.depth[static_cast<std::size_t>(y) * camera.width + static_cast<std::size_t>(x)];
  };
  image.cosine.assign(image.depth.size(), 0);
  image.slope.assign(image.depth.size(), glm::vec2(0));
  const auto add_to_row = [&](std::int64_t y) {
    for (std::int64_t x = 0; x < camera.width; ++x) {
      const float here = depth_at(x, y);
      if (!(here > 0)) continue;
      const double slope_x = slope(depth_at(x - 1, y), here, depth_at(x + 1, y));
      const double slope_y = slope(depth_at(x, y - 1), here, depth_at(x, y + 1));
      const glm::dvec3 ray((static_cast<double>(x) + 0.5 - camera.cx) / camera.fx,
                           (static_cast<double>(y) + 0.5 - camera.cy) / camera.fy, 1);
      const double value = cosine(camera, ray, here, slope_x, slope_y);
      if (value >= kLeastCosine) {  // false for NaN
        const std::size_t pixel = static_cast<std::size_t>(y) * camera.width + static_cast<std::size_t>(x);
        image.cosine[pixel] = static_cast<float>(value);
        image.slope[pixel] = glm::vec2(slope_x, slope_y);
      }
    }
  };
  constexpr std::size_t kRowsAtOnce = 16;
  tbb::parallel_for(tbb::blocked_range<std::int64_t>(0, camera.height, kRowsAtOnce), [&](const auto& rows) {
    for (std::int64_t y = rows.begin(); y < rows.end(); ++y) add_to_row(y);
  });
}

// Depths of no confidence become those that were not measured.
void leave_out_unsure(const SceneDepth& depth, GreyImage& image) {
  if (!depth.confidence) return;
  const Photograph confidence = read_photograph(*depth.confidence, Orientation::as_stored);
  if (confidence.width != image.width || confidence.height != image.height) {
    throw InputError(depth.confidence->string() + ": is " + size_text(confidence.width, confidence.height) +
                     " pixels, must have the size of its depth image, " + size_text(image.width, image.height));
  }
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    if (confidence.rgb[3 * i] == 0) image.values[i] = 0;
  }
}

}  // namespace

DepthImage slanted_depth(const Camera& camera, std::vector<float> depth) {
  DepthImage result;
  result.camera = camera;
  result.depth = std::move(depth);
  add_slant(result);
  for (std::size_t i = 0; i < result.depth.size(); ++i) {
    if (result.cosine[i] == 0) result.depth[i] = 0;
  }
  return result;
}

DepthImage read_flat_depth(const SceneDepth& depth) {
  GreyImage image = read_grey_image(depth.file);
  check_shape(image, depth);
  leave_out_unsure(depth, image);
  const Camera camera = depth.camera.scaled_to(image.width, image.height);
  return {camera, undistorted_depth(image, depth, camera)};
}

DepthImage read_depth(const SceneDepth& depth) {
  DepthImage flat = read_flat_depth(depth);
  return slanted_depth(flat.camera, std::move(flat.depth));
}

std::size_t pixels_above_zero(const SceneDepth& depth) {
  const GreyImage image = read_grey_image(depth.file);
  return static_cast<std::size_t>(
      std::count_if(image.values.begin(), image.values.end(), [](auto value) { return value > 0; }));
}

}  // namespace lumatlas
