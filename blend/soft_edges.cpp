// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/soft_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/trigonometric.hpp>
#include <glm/vec3.hpp>
#include <stdexcept>
#include <string>

#include "atlas/images/srgb.h"

namespace lumatlas {

namespace {

void require_pixels(std::size_t values, std::size_t pixels, const char* what) {
  if (values == pixels) return;
  throw std::invalid_argument("soft edges: " + std::string(what) + " has " + std::to_string(values) +
                              " values, must have one for each of the " + std::to_string(pixels) + " pixels");
}

// To the next pixel of a row or a column.
struct EdgeStep {
  int x, y;
};
constexpr std::array kEdgeSteps{EdgeStep{1, 0}, EdgeStep{0, 1}};

// Numbers of the pixels of an image.
struct EdgeGrid {
  int width, height;
  [[nodiscard]] bool has(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

// Calls function(x, y, pixel) for each pixel.
template <typename Function>
void for_each_pixel(const EdgeGrid& grid, const Function& function) {
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) function(x, y, grid.at(x, y));
  }
}

}  // namespace

double edge_variance(double deviation, double most_deviation, double focal_length, double depth) {
  const double off = std::min(deviation, most_deviation);
  const double shift = off * std::sin(glm::radians(kSoftEdgeDegrees)) * focal_length / depth;
  return std::clamp(shift * shift - 1, 0.0, kMostEdgeBlur * kMostEdgeBlur);
}

std::vector<float> edge_blur(const Camera& camera, const VisibilityBuffer& visible, const std::vector<float>& deviation,
                             double most_deviation) {
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  require_pixels(visible.depth.size(), pixels, "the depth");
  require_pixels(visible.face.size(), pixels, "the surface");
  require_pixels(deviation.size(), pixels, "the deviation");
  const EdgeGrid grid{static_cast<int>(camera.width), static_cast<int>(camera.height)};
  std::vector<double> blur(pixels, 0);
  for_each_pixel(grid, [&](int x, int y, std::size_t pixel) {
    if (visible.face[pixel] == FaceId::none) return;
    const double z = visible.depth[pixel];
    for (const EdgeStep& step : kEdgeSteps) {
      if (!grid.has(x - step.x, y - step.y) || !grid.has(x + step.x, y + step.y)) continue;
      const std::array three{pixel, grid.at(x - step.x, y - step.y), grid.at(x + step.x, y + step.y)};
      if (visible.face[three[1]] == FaceId::none || visible.face[three[2]] == FaceId::none) continue;
      const double bend = z / visible.depth[three[1]] + z / visible.depth[three[2]] - 2;
      if (!(std::abs(bend) > kEdgeBend)) continue;
      const std::size_t nearest = *std::min_element(three.begin(), three.end(), [&](std::size_t a, std::size_t b) {
        return visible.depth[a] < visible.depth[b];
      });
      const double depth = visible.depth[nearest];
      blur[pixel] = std::max(blur[pixel],
                             edge_variance(static_cast<double>(deviation[nearest]), most_deviation, camera.fx, depth));
    }
  });
  // Along rows, then along columns: r^2 is a sum over both.
  for (const EdgeStep& step : kEdgeSteps) {
    std::vector<double> spread(pixels, 0);
    for_each_pixel(grid, [&](int x, int y, std::size_t pixel) {
      for (int r = -kEdgeReach; r <= kEdgeReach; ++r) {
        if (!grid.has(x + r * step.x, y + r * step.y)) continue;
        const double from = blur[grid.at(x + r * step.x, y + r * step.y)];
        spread[pixel] = std::max(spread[pixel], from - kBlurFall * r * r);
      }
    });
    blur = std::move(spread);
  }
  return {blur.begin(), blur.end()};
}

Photograph with_soft_edges(const Photograph& picture, const std::vector<std::uint8_t>& seen,
                           const std::vector<float>& blur) {
  const std::size_t pixels = std::size_t{picture.width} * picture.height;
  require_pixels(picture.rgb.size(), 3 * pixels, "the picture");
  require_pixels(seen.size(), pixels, "what sees a surface");
  require_pixels(blur.size(), pixels, "the blur");
  const auto& linear = linear_from_srgb8();
  const EdgeGrid grid{static_cast<int>(picture.width), static_cast<int>(picture.height)};
  Photograph result = picture;
  for_each_pixel(grid, [&](int x, int y, std::size_t pixel) {
    if (!seen[pixel] || !(blur[pixel] > 0)) return;
    glm::dvec3 sum(0);
    double weights = 0;
    for (int row = std::max(y - kEdgeReach, 0); row <= std::min(y + kEdgeReach, grid.height - 1); ++row) {
      for (int column = std::max(x - kEdgeReach, 0); column <= std::min(x + kEdgeReach, grid.width - 1); ++column) {
        const std::size_t other = grid.at(column, row);
        if (!seen[other]) continue;
        const double squared = (column - x) * (column - x) + (row - y) * (row - y);
        const double weight = std::exp(-squared / (2 * static_cast<double>(blur[pixel])));
        const std::uint8_t* rgb = &picture.rgb[3 * other];
        sum += weight * glm::dvec3(linear[rgb[0]], linear[rgb[1]], linear[rgb[2]]);
        weights += weight;
      }
    }
    for (int channel = 0; channel < 3; ++channel) {
      result.rgb[3 * pixel + static_cast<std::size_t>(channel)] = srgb8_from_linear(sum[channel] / weights);
    }
  });
  return result;
}

}  // namespace lumatlas
