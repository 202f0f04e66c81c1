// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/filled_depth.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace lumatlas {

namespace {

// One level of the pyramid. Each level has half of the sides of the one before, rounded up.
struct Level {
  std::uint32_t width = 0, height = 0;
  std::vector<double> sum;     // weighted sum of the known inverse depths below a pixel
  std::vector<double> weight;  // sum of their weights
  std::vector<double> known;   // number of known pixels of the finest level below it, at most 1

  Level(std::uint32_t w, std::uint32_t h)
      : width(w), height(h), sum(std::size_t{w} * h), weight(sum.size()), known(sum.size()) {}
};

Level finest_level(std::span<const double> inverse_depth, std::uint32_t width, std::uint32_t height) {
  Level level(width, height);
  for (std::size_t pixel = 0; pixel < inverse_depth.size(); ++pixel) {
    const double inverse = inverse_depth[pixel];
    if (!(inverse > 0)) continue;
    level.weight[pixel] = 1 / (inverse * inverse);
    level.sum[pixel] = 1 / inverse;
    level.known[pixel] = 1;
  }
  return level;
}

Level coarser_level(const Level& fine) {
  Level coarse((fine.width + 1) / 2, (fine.height + 1) / 2);
  for (std::uint32_t y = 0; y < fine.height; ++y) {
    for (std::uint32_t x = 0; x < fine.width; ++x) {
      const std::size_t from = std::size_t{y} * fine.width + x, to = std::size_t{y / 2} * coarse.width + x / 2;
      coarse.sum[to] += fine.sum[from];
      coarse.weight[to] += fine.weight[from];
      coarse.known[to] = std::min(coarse.known[to] + fine.known[from], 1.0);
    }
  }
  return coarse;
}

// The two pixels of a coarser row between whose middles that of a finer one lies, and the second one's share.
struct Between {
  std::size_t first, second;
  double share;
};
Between between(std::uint32_t fine, std::uint32_t coarse_size) {
  const double at = std::clamp((fine + 0.5) / 2 - 0.5, 0.0, static_cast<double>(coarse_size) - 1);
  const auto first = static_cast<std::size_t>(at);
  return {first, std::min<std::size_t>(first + 1, coarse_size - 1), at - std::floor(at)};
}

// Returns the values of a level from those of the next coarser one, of which each is 0 only if all are.
std::vector<double> refined(const Level& fine, const Level& coarse, const std::vector<double>& values) {
  std::vector<double> result(fine.sum.size());
  for (std::uint32_t y = 0; y < fine.height; ++y) {
    const Between row = between(y, coarse.height);
    for (std::uint32_t x = 0; x < fine.width; ++x) {
      const Between column = between(x, coarse.width);
      double sum = 0, weights = 0;
      const auto add = [&](std::size_t coarse_row, std::size_t coarse_column, double share) {
        const double value = values[coarse_row * coarse.width + coarse_column];
        if (!(value > 0)) return;
        sum += share / value;
        weights += share / (value * value);
      };
      add(row.first, column.first, (1 - row.share) * (1 - column.share));
      add(row.first, column.second, (1 - row.share) * column.share);
      add(row.second, column.first, row.share * (1 - column.share));
      add(row.second, column.second, row.share * column.share);
      const std::size_t pixel = std::size_t{y} * fine.width + x;
      const double known = fine.known[pixel];
      result[pixel] = weights > 0 ? (1 - known) * sum / weights : 0;
      if (known > 0) result[pixel] += known * fine.sum[pixel] / fine.weight[pixel];
    }
  }
  return result;
}

}  // namespace

std::vector<double> filled_inverse_depth(std::span<const double> inverse_depth, std::uint32_t width,
                                         std::uint32_t height) {
  if (width == 0 || height == 0 || inverse_depth.size() != std::size_t{width} * height) {
    throw std::invalid_argument("filled_inverse_depth: an inverse depth is needed for each pixel");
  }
  std::vector<Level> levels{finest_level(inverse_depth, width, height)};
  while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(coarser_level(levels.back()));
  const Level& top = levels.back();
  std::vector<double> values{top.weight[0] > 0 ? top.sum[0] / top.weight[0] : 0};
  for (std::size_t i = levels.size() - 1; i-- > 0;) values = refined(levels[i], levels[i + 1], values);
  for (std::size_t pixel = 0; pixel < values.size(); ++pixel) {
    if (inverse_depth[pixel] > 0) values[pixel] = inverse_depth[pixel];
  }
  return values;
}

}  // namespace lumatlas
