// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/surface_samples.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr double kFarFromWhole = 0.381966;  // of all fractions, this one's multiples are spread most evenly
constexpr float kDepthEdge = 0.05f;         // of the nearer depth, as in the validity masks

constexpr Requirement surface_samples_requires{"surface samples"};

// The photograph at about the resolution of the visibility buffer, and where the buffer's pixels are in both.
struct SampleGrid {
  const Pyramid& photograph;
  const PhotographSpan& reduced;
  const VisibilityBuffer& visible;

  [[nodiscard]] glm::dvec2 image_of(std::uint32_t x, std::uint32_t y) const {
    const PhotographSpan& full = photograph.level(0);
    return {(x + 0.5) * full.width / visible.width, (y + 0.5) * full.height / visible.height};
  }
  [[nodiscard]] glm::uvec2 reduced_pixel(std::uint32_t x, std::uint32_t y) const {
    return {std::min(reduced.width - 1, static_cast<std::uint32_t>((x + 0.5) * reduced.width / visible.width)),
            std::min(reduced.height - 1, static_cast<std::uint32_t>((y + 0.5) * reduced.height / visible.height))};
  }
};

bool is_smooth(const VisibilityBuffer& visible, std::uint32_t x, std::uint32_t y) {
  const float z = visible.depth[std::size_t{y} * visible.width + x];
  if (!std::isfinite(z)) return false;
  const std::uint32_t right = std::min(x + 1, visible.width - 1);
  const std::uint32_t bottom = std::min(y + 1, visible.height - 1);
  for (std::uint32_t ny = y - (y > 0); ny <= bottom; ++ny) {
    for (std::uint32_t nx = x - (x > 0); nx <= right; ++nx) {
      const float neighbour = visible.depth[std::size_t{ny} * visible.width + nx];
      if (!(std::abs(z - neighbour) <= kDepthEdge * std::min(z, neighbour))) return false;
    }
  }
  return true;
}

// Sum over channels of the squared central differences, 8-bit sRGB. In place of an invalid pixel, which is black, the
// one in the middle is taken: otherwise most samples would lie along masks.
int gradient(const PhotographSpan& image, const glm::uvec2& at) {
  const std::size_t middle = std::size_t{at.y} * image.width + at.x;
  const auto pixel = [&](std::uint32_t x, std::uint32_t y) {
    const std::size_t index = std::size_t{y} * image.width + x;
    return &image.rgb[3 * (image.valid.empty() || image.valid[index] != 0 ? index : middle)];
  };
  const std::uint8_t* left = pixel(at.x - (at.x > 0), at.y);
  const std::uint8_t* right = pixel(std::min(at.x + 1, image.width - 1), at.y);
  const std::uint8_t* above = pixel(at.x, at.y - (at.y > 0));
  const std::uint8_t* below = pixel(at.x, std::min(at.y + 1, image.height - 1));
  int sum = 0;
  for (int channel = 0; channel < 3; ++channel) {
    const int dx = right[channel] - left[channel];
    const int dy = below[channel] - above[channel];
    sum += dx * dx + dy * dy;
  }
  return sum;
}

struct SampleBlock {
  std::uint32_t left, top, right, bottom;
};

// The pixels that are chosen from one block, at most two.
std::vector<glm::uvec2> chosen(const SampleGrid& grid, const SampleBlock& block) {
  const glm::ivec2 middle((block.left + block.right) / 2, (block.top + block.bottom) / 2);
  int steepest = -1;
  int nearest = std::numeric_limits<int>::max();
  glm::uvec2 sharp(0), central(0);
  for (std::uint32_t y = block.top; y < block.bottom; ++y) {
    for (std::uint32_t x = block.left; x < block.right; ++x) {
      const glm::uvec2 at = grid.reduced_pixel(x, y);
      const std::uint8_t* rgb = &grid.reduced.rgb[3 * (std::size_t{at.y} * grid.reduced.width + at.x)];
      if (!is_exposed(rgb) || !is_smooth(grid.visible, x, y) || !grid.photograph.is_valid(grid.image_of(x, y)))
        continue;
      const int steepness = gradient(grid.reduced, at);
      if (steepness > steepest) steepest = steepness, sharp = {x, y};
      const glm::ivec2 off = glm::ivec2(x, y) - middle;
      const int distance = off.x * off.x + off.y * off.y;
      if (distance < nearest) nearest = distance, central = {x, y};
    }
  }
  if (steepest < 0) return {};
  if (sharp == central) return {sharp};
  return {sharp, central};
}

SurfaceSample sample_at(const SampleGrid& grid, const Camera& camera, const glm::uvec2& pixel) {
  const std::size_t index = std::size_t{pixel.y} * grid.visible.width + pixel.x;
  const glm::dvec2 image = grid.image_of(pixel.x, pixel.y);
  return {camera.center() + static_cast<double>(grid.visible.depth[index]) * camera.ray(image), image,
          grid.visible.face[index]};
}

}  // namespace

bool is_exposed(const std::uint8_t* rgb) {
  const auto [least, most] = std::minmax({rgb[0], rgb[1], rgb[2]});
  return most >= kDarkestSample && most <= kBrightestSample && least < kBrightestSample;
}

std::uint32_t sampling_px(std::uint32_t photograph_px, std::uint32_t most_px) {
  surface_samples_requires(photograph_px >= 1, "photograph_px", photograph_px, "at least 1");
  surface_samples_requires(most_px >= 1, "most_px", most_px, "at least 1");
  const double pixels = std::max(1.0, std::ceil(static_cast<double>(photograph_px) / most_px - kFarFromWhole));
  return std::max(1u, static_cast<std::uint32_t>(photograph_px / (pixels + kFarFromWhole)));
}

std::vector<SurfaceSample> choose_surface_samples(const Camera& camera, const Pyramid& photograph,
                                                  const VisibilityBuffer& visible, std::size_t count) {
  surface_samples_requires(photograph.level(0).width == camera.width, "camera.width", camera.width, "the photograph's");
  surface_samples_requires(photograph.level(0).height == camera.height, "camera.height", camera.height,
                           "the photograph's");
  surface_samples_requires(visible.width >= 1 && visible.height >= 1, "visible.width", visible.width,
                           "at least 1, and so the height");
  const std::size_t all_pixels = std::size_t{visible.width} * visible.height;
  surface_samples_requires.has_size(visible.depth.size(), all_pixels, "visible.depth", "the number of its pixels");
  surface_samples_requires.has_size(visible.face.size(), all_pixels, "visible.face", "the number of its pixels");
  const std::uint32_t level = photograph.level_near(std::max(visible.width, visible.height));
  const SampleGrid grid{photograph, photograph.level(level), visible};
  const double pixels = static_cast<double>(visible.width) * visible.height;
  const auto side = static_cast<std::uint32_t>(
      std::max(1.0, std::floor(std::sqrt(2 * pixels / static_cast<double>(std::max<std::size_t>(count, 1))))));
  const std::uint32_t columns = (visible.width + side - 1) / side;
  const std::uint32_t rows = (visible.height + side - 1) / side;
  std::vector<std::vector<glm::uvec2>> by_row(rows);
  tbb::parallel_for(0u, rows, [&](std::uint32_t row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const SampleBlock block{column * side, row * side, std::min(visible.width, (column + 1) * side),
                              std::min(visible.height, (row + 1) * side)};
      const std::vector<glm::uvec2> pixels_of_block = chosen(grid, block);
      by_row[row].insert(by_row[row].end(), pixels_of_block.begin(), pixels_of_block.end());
    }
  });
  std::vector<SurfaceSample> samples;
  for (const std::vector<glm::uvec2>& row : by_row) {
    for (const glm::uvec2& pixel : row) samples.push_back(sample_at(grid, camera, pixel));
  }
  return samples;
}

}  // namespace lumatlas
