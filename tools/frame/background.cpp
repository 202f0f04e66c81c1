// SPDX-License-Identifier: GPL-3.0-or-later
// Source of the blurred colours: S. Gortler et al., "The Lumigraph", 1996, section 3.4.2, pull and push.
#include "tools/frame/background.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <stdexcept>
#include <utility>

#include "atlas/images/srgb.h"
#include "tools/texture/layout/edge_distance.h"

namespace lumatlas {

namespace {

constexpr double kSoftShare = 0.01;     // share of the longer side, over which the surface fades
constexpr std::uint32_t kBlurCell = 4;  // pixels; colours beside the surface are means over squares of this side
constexpr float kGuess = 0.01F;  // weight of a colour that no photograph shows against one that a photograph shows

// Colours times weights, and weights, on a grid.
struct Grid {
  std::uint32_t width = 0, height = 0;
  std::vector<glm::vec4> cells;

  Grid(std::uint32_t w, std::uint32_t h) : width(w), height(h), cells(std::size_t{w} * h, glm::vec4(0)) {}
  [[nodiscard]] glm::vec4& at(std::uint32_t x, std::uint32_t y) { return cells[std::size_t{y} * width + x]; }
  [[nodiscard]] const glm::vec4& at(std::uint32_t x, std::uint32_t y) const {
    return cells[std::size_t{y} * width + x];
  }
  // Bilinear between the cells' middles; `x` and `y` in cells.
  [[nodiscard]] glm::vec4 between(float x, float y) const {
    const float left = std::clamp(x - 0.5f, 0.0f, static_cast<float>(width - 1));
    const float top = std::clamp(y - 0.5f, 0.0f, static_cast<float>(height - 1));
    const auto column = static_cast<std::uint32_t>(left);
    const auto row = static_cast<std::uint32_t>(top);
    const std::uint32_t right = std::min(column + 1, width - 1);
    const std::uint32_t bottom = std::min(row + 1, height - 1);
    const float fx = left - static_cast<float>(column);
    const float fy = top - static_cast<float>(row);
    return glm::mix(glm::mix(at(column, row), at(right, row), fx), glm::mix(at(column, bottom), at(right, bottom), fx),
                    fy);
  }
};

Grid halved(const Grid& fine) {
  Grid coarse((fine.width + 1) / 2, (fine.height + 1) / 2);
  for (std::uint32_t y = 0; y < fine.height; ++y) {
    for (std::uint32_t x = 0; x < fine.width; ++x) coarse.at(x / 2, y / 2) += fine.at(x, y);
  }
  return coarse;
}

// Weights of at most 1.
void saturate(Grid& grid) {
  for (glm::vec4& cell : grid.cells) {
    if (cell.w > 1) cell /= cell.w;
  }
}

// Every cell gets a weight of 1: what it lacks comes from the next coarser grid.
void fill(Grid& grid) {
  saturate(grid);
  if (grid.width == 1 && grid.height == 1) {
    if (grid.cells[0].w > 0) grid.cells[0] /= grid.cells[0].w;
    return;
  }
  Grid coarse = halved(grid);
  fill(coarse);
  for (std::uint32_t y = 0; y < grid.height; ++y) {
    for (std::uint32_t x = 0; x < grid.width; ++x) {
      glm::vec4& cell = grid.at(x, y);
      if (cell.w >= 1) continue;
      cell += (1 - cell.w) * coarse.between((static_cast<float>(x) + 0.5f) / 2, (static_cast<float>(y) + 0.5f) / 2);
    }
  }
}

// A picture in linear light, whatever held it.
struct Linear {
  std::uint32_t width, height;
  const std::vector<PixelState>& state;
  std::vector<float> rgb;

  [[nodiscard]] glm::vec3 color(std::size_t pixel) const {
    return {rgb[3 * pixel], rgb[3 * pixel + 1], rgb[3 * pixel + 2]};
  }
};

// The surface's colours, continued beyond it.
Grid continued(const Linear& picture) {
  Grid grid((picture.width + kBlurCell - 1) / kBlurCell, (picture.height + kBlurCell - 1) / kBlurCell);
  for (std::uint32_t y = 0; y < picture.height; ++y) {
    for (std::uint32_t x = 0; x < picture.width; ++x) {
      const std::size_t pixel = std::size_t{y} * picture.width + x;
      if (picture.state[pixel] == PixelState::empty) continue;
      const float weight = picture.state[pixel] == PixelState::textured ? 1 : kGuess;
      grid.at(x / kBlurCell, y / kBlurCell) += weight * glm::vec4(picture.color(pixel), 1);
    }
  }
  fill(grid);
  return grid;
}

// Calls use(pixel, behind, coverage) for each pixel that the surface does not cover wholly: `behind` is the
// background's colour there, and `coverage` the surface's share.
template <typename Use>
void each_open_pixel(const Linear& picture, const Background& background, const std::vector<float>& coverage,
                     const Use& use) {
  const auto& linear = linear_from_srgb8();
  const glm::vec3 plain(linear[background.color[0]], linear[background.color[1]], linear[background.color[2]]);
  const bool is_plain = background.kind == Background::Kind::plain;
  const Grid around = is_plain ? Grid(1, 1) : continued(picture);
  tbb::parallel_for(std::uint32_t{0}, picture.height, [&](std::uint32_t y) {
    for (std::uint32_t x = 0; x < picture.width; ++x) {
      const std::size_t pixel = std::size_t{y} * picture.width + x;
      if (coverage[pixel] >= 1) continue;
      const glm::vec3 behind = is_plain ? plain
                                        : glm::vec3(around.between((static_cast<float>(x) + 0.5f) / kBlurCell,
                                                                   (static_cast<float>(y) + 0.5f) / kBlurCell));
      use(pixel, behind, coverage[pixel]);
    }
  });
}

bool all_covered(const std::vector<PixelState>& state) {
  return std::find(state.begin(), state.end(), PixelState::empty) == state.end();
}

std::optional<std::array<std::uint8_t, 3>> color_named(const std::string& name) {
  if (name == "black") return std::array<std::uint8_t, 3>{0, 0, 0};
  if (name == "white") return std::array<std::uint8_t, 3>{255, 255, 255};
  if (name.size() != 7 || name[0] != '#' || name.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos) {
    return std::nullopt;
  }
  std::array<std::uint8_t, 3> color{};
  for (std::size_t i = 0; i < 3; ++i) {
    color.at(i) = static_cast<std::uint8_t>(std::stoi(name.substr(1 + 2 * i, 2), nullptr, 16));
  }
  return color;
}

std::vector<float> linear_values(const Photograph& picture) {
  const auto& linear = linear_from_srgb8();
  std::vector<float> values(picture.rgb.size());
  std::transform(picture.rgb.begin(), picture.rgb.end(), values.begin(),
                 [&](std::uint8_t value) { return static_cast<float>(linear[value]); });
  return values;
}

}  // namespace

std::optional<Background> background_named(const std::string& name) {
  if (name == "alpha") return Background{Background::Kind::transparent, {}};
  if (name == "blur") return Background{Background::Kind::blurred, {}};
  const auto color = color_named(name);
  if (!color) return std::nullopt;
  return Background{Background::Kind::plain, *color};
}

std::vector<float> soft_coverage(const std::vector<PixelState>& state, std::uint32_t width, std::uint32_t height) {
  if (state.size() != std::size_t{width} * height) {
    throw std::invalid_argument("background: there must be a state for each pixel");
  }
  const auto soft = static_cast<std::uint32_t>(std::max(1.0, std::ceil(kSoftShare * std::max(width, height))));
  // With a border in which the outermost pixels go on, because distances are to the picture's border as well.
  const std::uint32_t wide = width + 2 * soft, high = height + 2 * soft;
  std::vector<std::uint8_t> seen(std::size_t{wide} * high);
  for (std::uint32_t y = 0; y < high; ++y) {
    const std::uint32_t row = std::clamp(y, soft, soft + height - 1) - soft;
    for (std::uint32_t x = 0; x < wide; ++x) {
      const std::uint32_t column = std::clamp(x, soft, soft + width - 1) - soft;
      seen[std::size_t{y} * wide + x] = state[std::size_t{row} * width + column] != PixelState::empty;
    }
  }
  const std::vector<float> distances = edge_distances(seen, wide, high);
  std::vector<float> coverage(state.size());
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const float distance = distances[std::size_t{y + soft} * wide + x + soft];
      coverage[std::size_t{y} * width + x] = std::clamp(distance / static_cast<float>(soft + 1), 0.0f, 1.0f);
    }
  }
  return coverage;
}

SoftPicture with_background(const Rendering& rendering, const Background& background) {
  SoftPicture soft{rendering.picture, {}};
  const bool transparent = background.kind == Background::Kind::transparent;
  if (transparent) soft.alpha.assign(rendering.state.size(), 255);
  if (all_covered(rendering.state)) return soft;
  const Photograph& picture = rendering.picture;
  const Linear linear{picture.width, picture.height, rendering.state, linear_values(picture)};
  const std::vector<float> coverage = soft_coverage(rendering.state, picture.width, picture.height);
  each_open_pixel(linear, background, coverage, [&](std::size_t pixel, const glm::vec3& behind, float share) {
    if (transparent) soft.alpha[pixel] = static_cast<std::uint8_t>(std::lround(255 * share));
    if (transparent && share > 0) return;  // its colour is the surface's
    const glm::vec3 shown = glm::mix(behind, linear.color(pixel), share);
    for (int channel = 0; channel < 3; ++channel) {
      soft.picture.rgb[3 * pixel + static_cast<std::size_t>(channel)] = srgb8_from_linear(shown[channel]);
    }
  });
  return soft;
}

FloatImage with_background(const LinearRendering& rendering, const Background& background) {
  const bool transparent = background.kind == Background::Kind::transparent;
  FloatImage image{rendering.width, rendering.height, {"R", "G", "B"}, rendering.rgb};
  std::vector<float> coverage(rendering.state.size(), 1.0f);
  if (!all_covered(rendering.state)) {
    coverage = soft_coverage(rendering.state, rendering.width, rendering.height);
    if (!transparent) {
      const Linear linear{rendering.width, rendering.height, rendering.state, rendering.rgb};
      each_open_pixel(linear, background, coverage, [&](std::size_t pixel, const glm::vec3& behind, float share) {
        const glm::vec3 shown = glm::mix(behind, linear.color(pixel), share);
        for (int channel = 0; channel < 3; ++channel) {
          image.values[3 * pixel + static_cast<std::size_t>(channel)] = shown[channel];
        }
      });
    }
  }
  if (!transparent) return image;
  image.channels.emplace_back("A");
  image.values.resize(4 * coverage.size());
  for (std::size_t pixel = 0; pixel < coverage.size(); ++pixel) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      image.values[4 * pixel + channel] = coverage[pixel] * rendering.rgb[3 * pixel + channel];
    }
    image.values[4 * pixel + 3] = coverage[pixel];
  }
  return image;
}

}  // namespace lumatlas
