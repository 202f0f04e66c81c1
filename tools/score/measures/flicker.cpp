// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/measures/flicker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <stdexcept>
#include <utility>

namespace lumatlas {

namespace {

// Inverse depth is linear over the picture of a plane, however steeply it is seen.
constexpr float kBend = 0.02F;       // share of inverse depth, over three pixels of one surface
constexpr double kSamePoint = 0.01;  // share of a point's depth from one frame to the next

std::vector<float> inverse_depths(const VisibilityBuffer& visible) {
  std::vector<float> inverse(visible.depth.size());
  std::transform(visible.depth.begin(), visible.depth.end(), inverse.begin(), [](float depth) { return 1 / depth; });
  return inverse;
}

constexpr std::size_t kMargin = 2;  // pixels that smoothing reaches to either side

// Returns whether all pixels that smoothing mixes into this one, which is not near the picture's border, are inside the
// lens's image: the others are black.
bool smoothed_from_valid(const Photograph& truth, std::size_t middle) {
  if (truth.valid.empty()) return true;
  for (std::size_t row = 0; row <= 2 * kMargin; ++row) {
    const std::size_t first = middle - kMargin + row * truth.width - kMargin * truth.width;
    for (std::size_t i = 0; i <= 2 * kMargin; ++i) {
      if (truth.valid[first + i] == 0) return false;
    }
  }
  return true;
}

// Inverse depth of the pixels that lie on one surface, and inside the lens's image, with all that smoothing mixes; 0
// elsewhere and along the picture's border.
std::vector<float> whole_inverse_depths(const VisibilityBuffer& visible, const Photograph& truth) {
  const std::size_t width = visible.width;
  const std::vector<float> inverse = inverse_depths(visible);  // 0 where no surface is
  std::vector<float> whole(inverse.size(), 0.0F);
  for (std::size_t y = kMargin; y + kMargin < visible.height; ++y) {
    for (std::size_t x = kMargin; x + kMargin < width; ++x) {
      const std::size_t middle = y * width + x;
      const auto straight = [&](std::size_t stride) {
        const float bend = inverse[middle - stride] - 2 * inverse[middle] + inverse[middle + stride];
        return std::abs(bend) <= kBend * inverse[middle];
      };
      bool on_one_surface = true;
      for (std::size_t far = 1; far <= kMargin; ++far) {
        for (const std::size_t stride : {std::size_t{1}, width - 1, width, width + 1}) {
          on_one_surface = on_one_surface && straight(far * stride);
        }
      }
      if (on_one_surface && smoothed_from_valid(truth, middle)) whole[middle] = inverse[middle];
    }
  }
  return whole;
}

// (1 4 6 4 1)/16 along one direction; what reaches over the ends is 0.
std::vector<float> smoothed(const std::vector<float>& values, std::size_t stride) {
  std::vector<float> result(values.size(), 0.0F);
  for (std::size_t i = kMargin * stride; i + kMargin * stride < values.size(); ++i) {
    result[i] = (values[i - 2 * stride] + 4 * values[i - stride] + 6 * values[i] + 4 * values[i + stride] +
                 values[i + 2 * stride]) /
                16;
  }
  return result;
}

// Returns the error of one channel; of no use within kMargin of the picture's border.
std::vector<float> smoothed_error(const Photograph& rendering, const Photograph& truth, std::size_t channel) {
  std::vector<float> error(std::size_t{truth.width} * truth.height);
  for (std::size_t pixel = 0; pixel < error.size(); ++pixel) {
    error[pixel] =
        static_cast<float>(rendering.rgb[3 * pixel + channel]) - static_cast<float>(truth.rgb[3 * pixel + channel]);
  }
  return smoothed(smoothed(error, 1), truth.width);
}

// Bilinear interpolation between four pixels.
struct Taps {
  std::array<std::size_t, 4> pixels;
  std::array<double, 4> shares;

  [[nodiscard]] double of(const std::vector<float>& values) const {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += shares[i] * values[pixels[i]];
    return sum;
  }
  [[nodiscard]] bool all_positive(const std::vector<float>& values) const {
    return std::all_of(pixels.begin(), pixels.end(), [&](std::size_t pixel) { return values[pixel] > 0; });
  }
};

// Returns nothing for a point in the camera's frame that is behind it or not between the middles of four pixels.
std::optional<Taps> taps_around(const Camera& camera, const glm::dvec3& cam) {
  if (!(cam.z > 0)) return std::nullopt;
  const glm::dvec2 at = camera.image_from_cam(cam) - 0.5;
  if (!(at.x >= 0 && at.y >= 0 && at.x < camera.width - 1.0 && at.y < camera.height - 1.0)) return std::nullopt;
  const glm::dvec2 base = glm::floor(at);
  const glm::dvec2 f = at - base;
  const std::size_t corner = static_cast<std::size_t>(base.y) * camera.width + static_cast<std::size_t>(base.x);
  return Taps{{corner, corner + 1, corner + camera.width, corner + camera.width + 1},
              {(1 - f.x) * (1 - f.y), f.x * (1 - f.y), (1 - f.x) * f.y, f.x * f.y}};
}

void check_sizes(const Camera& camera, const VisibilityBuffer& visible, const Photograph& rendering,
                 const Photograph& truth) {
  const auto has_size = [&](const auto& picture) {
    return picture.width == camera.width && picture.height == camera.height;
  };
  if (!has_size(visible) || !has_size(rendering) || !has_size(truth)) {
    throw std::invalid_argument("flicker: pictures and visibility buffer must be as large as the camera's image");
  }
}

}  // namespace

void FlickerMeter::add(const Camera& camera, const VisibilityBuffer& visible, const Photograph& rendering,
                       const Photograph& truth) {
  check_sizes(camera, visible, rendering, truth);
  Frame frame;
  frame.camera = camera;
  frame.inverse_depth = whole_inverse_depths(visible, truth);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    frame.error[channel] = smoothed_error(rendering, truth, channel);
  }
  if (previous_) compare(*previous_, frame);
  previous_ = std::move(frame);
}

void FlickerMeter::compare(const Frame& from, const Frame& to) {
  const std::size_t width = from.camera.width;
  double squares = 0;
  std::size_t followed = 0;
  for (std::size_t pixel = 0; pixel < from.inverse_depth.size(); ++pixel) {
    if (from.inverse_depth[pixel] == 0) continue;
    const glm::dvec2 middle(static_cast<double>(pixel % width) + 0.5, static_cast<double>(pixel / width) + 0.5);
    const glm::dvec3 world = from.camera.center() + from.camera.ray(middle) / double{from.inverse_depth[pixel]};
    const glm::dvec3 cam = to.camera.cam_from_world(world);
    const std::optional<Taps> taps = taps_around(to.camera, cam);
    if (!taps || !taps->all_positive(to.inverse_depth)) continue;
    if (std::abs(taps->of(to.inverse_depth) * cam.z - 1) > kSamePoint) continue;
    ++followed;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const double change = taps->of(to.error[channel]) - from.error[channel][pixel];
      squares += change * change / 3;
    }
  }
  if (followed == 0) return;
  squares_ += squares;
  followed_ += followed;
  worst_square_ = std::max(worst_square_, squares / static_cast<double>(followed));
}

Flicker FlickerMeter::flicker() const {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  if (followed_ == 0) return {kNaN, kNaN, 0};
  return {std::sqrt(squares_ / static_cast<double>(followed_)), std::sqrt(worst_square_), followed_};
}

}  // namespace lumatlas
