// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/flicker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <stdexcept>
#include <utility>

namespace lumatlas {

namespace {

constexpr float kWithinPixels = 1.02F;  // depths of neighbouring pixels on one surface
constexpr double kSamePoint = 0.01;     // of a point's depth from one frame to the next

// Depth of the pixels whose neighbourhood is all on one surface, 0 elsewhere and along the picture's border.
std::vector<float> whole_depths(const VisibilityBuffer& visible) {
  const std::size_t width = visible.width;
  std::vector<float> depths(visible.depth.size(), 0.0F);
  for (std::size_t y = 1; y + 1 < visible.height; ++y) {
    for (std::size_t x = 1; x + 1 < width; ++x) {
      float near = std::numeric_limits<float>::infinity();
      float far = 0;
      for (std::size_t j = y - 1; j <= y + 1; ++j) {
        for (std::size_t i = x - 1; i <= x + 1; ++i) {
          near = std::min(near, visible.depth[j * width + i]);
          far = std::max(far, visible.depth[j * width + i]);
        }
      }
      if (std::isfinite(far) && far <= kWithinPixels * near) depths[y * width + x] = visible.depth[y * width + x];
    }
  }
  return depths;
}

// Of one channel, where whole_depths() is not 0; 0 along the picture's border.
std::vector<float> smoothed_error(const Photograph& rendering, const Photograph& truth, std::size_t channel) {
  const std::size_t width = truth.width;
  const auto error = [&](std::size_t pixel) {
    return static_cast<float>(rendering.rgb[3 * pixel + channel]) - static_cast<float>(truth.rgb[3 * pixel + channel]);
  };
  std::vector<float> smooth(width * truth.height, 0.0F);
  for (std::size_t y = 1; y + 1 < truth.height; ++y) {
    for (std::size_t x = 1; x + 1 < width; ++x) {
      const std::size_t middle = y * width + x;
      const auto row = [&](std::size_t at) { return error(at - 1) + 2 * error(at) + error(at + 1); };
      smooth[middle] = (row(middle - width) + 2 * row(middle) + row(middle + width)) / 16;
    }
  }
  return smooth;
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
  frame.depth = whole_depths(visible);
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
  for (std::size_t pixel = 0; pixel < from.depth.size(); ++pixel) {
    if (from.depth[pixel] == 0) continue;
    const glm::dvec2 middle(static_cast<double>(pixel % width) + 0.5, static_cast<double>(pixel / width) + 0.5);
    const glm::dvec3 cam =
        to.camera.cam_from_world(from.camera.center() + double{from.depth[pixel]} * from.camera.ray(middle));
    if (!(cam.z > 0)) continue;
    const glm::dvec2 at = to.camera.image_from_cam(cam) - 0.5;
    if (!(at.x >= 0 && at.y >= 0 && at.x < to.camera.width - 1.0 && at.y < to.camera.height - 1.0)) continue;
    const glm::dvec2 base = glm::floor(at);
    const glm::dvec2 f = at - base;
    const std::size_t corner = static_cast<std::size_t>(base.y) * to.camera.width + static_cast<std::size_t>(base.x);
    const std::array<std::size_t, 4> taps{corner, corner + 1, corner + to.camera.width, corner + to.camera.width + 1};
    const std::array<double, 4> shares{(1 - f.x) * (1 - f.y), f.x * (1 - f.y), (1 - f.x) * f.y, f.x * f.y};
    const bool same_point = std::all_of(taps.begin(), taps.end(), [&](std::size_t tap) {
      return std::abs(to.depth[tap] - cam.z) <= kSamePoint * cam.z;  // 0 where not followed
    });
    if (!same_point) continue;
    ++followed;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      double change = -from.error[channel][pixel];
      for (std::size_t i = 0; i < 4; ++i) change += shares[i] * to.error[channel][taps[i]];
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
