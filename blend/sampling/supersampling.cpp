// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/sampling/supersampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace lumatlas {

namespace {

// From a pixel to one of two opposite neighbours.
struct Step {
  int x, y;
};
constexpr std::array kSteps{Step{1, 0}, Step{0, 1}, Step{1, 1}, Step{1, -1}};

bool at_silhouette(const Camera& camera, const VisibilityBuffer& visible, int x, int y) {
  const auto width = static_cast<int>(visible.width);
  const auto height = static_cast<int>(visible.height);
  const auto pixel = [&](int column, int row) { return static_cast<std::size_t>(row) * visible.width + column; };
  if (visible.face[pixel(x, y)] == FaceId::none) return false;
  const double z = visible.depth[pixel(x, y)];
  for (const Step& step : kSteps) {
    double bend = -2;
    int inside = 0;
    for (const int side : {-1, 1}) {
      const int column = x + side * step.x;
      const int row = y + side * step.y;
      if (column < 0 || row < 0 || column >= width || row >= height) continue;
      if (visible.face[pixel(column, row)] == FaceId::none) return true;
      bend += z / visible.depth[pixel(column, row)];
      ++inside;
    }
    if (inside == 2 && camera.fx * std::abs(bend) > kSilhouetteBend) return true;
  }
  return false;
}

// A colour that stands for a surface in a pixel.
struct Standing {
  double depth;
  std::uint8_t* count;
};

}  // namespace

std::vector<Camera> sample_cameras(const Camera& camera, std::uint32_t across) {
  check(camera);
  if (across < 1 || across > kMostSupersampling) {
    throw std::invalid_argument("supersampling: across is " + std::to_string(across) + ", must be in [1, " +
                                std::to_string(kMostSupersampling) + "]");
  }
  std::vector<Camera> cameras;
  for (std::uint32_t row = 0; row < across; ++row) {
    for (std::uint32_t column = 0; column < across; ++column) {
      Camera& sample = cameras.emplace_back(camera);
      sample.cx -= (column + 0.5) / across - 0.5;
      sample.cy -= (row + 0.5) / across - 0.5;
    }
  }
  return cameras;
}

std::vector<std::uint8_t> silhouettes(const Camera& camera, const VisibilityBuffer& visible) {
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  if (visible.width != camera.width || visible.height != camera.height || visible.depth.size() != pixels ||
      visible.face.size() != pixels) {
    throw std::invalid_argument("silhouettes: the visibility buffer must be as large as the camera's image");
  }
  std::vector<std::uint8_t> flags;
  flags.reserve(visible.face.size());
  for (int y = 0; y < static_cast<int>(visible.height); ++y) {
    for (int x = 0; x < static_cast<int>(visible.width); ++x) {
      flags.push_back(at_silhouette(camera, visible, x, y) ? 1 : 0);
    }
  }
  return flags;
}

SampleCounts sample_counts(const Camera& camera, const VisibilityBuffer& visible,
                           std::span<const VisibilityBuffer> samples, const std::vector<std::uint8_t>& sampled,
                           BlendOptions::Antialias antialias) {
  const bool each = antialias == BlendOptions::Antialias::all;
  SampleCounts counts;
  counts.middle.resize(sampled.size());
  counts.samples.assign(samples.size(), std::vector<std::uint8_t>(sampled.size()));
  for (std::size_t pixel = 0; pixel < sampled.size(); ++pixel) {
    if (sampled[pixel] == 0 || visible.face[pixel] == FaceId::none) continue;
    std::vector<Standing> colors;
    if (!each) colors.push_back({visible.depth[pixel], &counts.middle[pixel]});
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (samples[i].face[pixel] == FaceId::none) continue;
      const double depth = samples[i].depth[pixel];
      const auto found = std::find_if(colors.begin(), colors.end(), [&](const Standing& color) {
        return !each && camera.fx * std::abs(color.depth / depth - 1) < kSameSurface;
      });
      std::uint8_t* const count = found != colors.end() ? found->count : &counts.samples[i][pixel];
      if (found == colors.end()) colors.push_back({depth, count});
      ++*count;
    }
  }
  return counts;
}

BlendOptions at_middle(const BlendOptions& options) {
  BlendOptions middle = options;
  middle.supersample = 1;
  return middle;
}

}  // namespace lumatlas
