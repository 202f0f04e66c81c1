// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/validity.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace lumatlas {

namespace {

struct Shift {
  int dx, dy;
};

// SW(U) of section 3.1: the disc of whole-pixel shifts.
std::vector<Shift> search_window(std::uint32_t radius) {
  std::vector<Shift> window;
  const int r = static_cast<int>(radius);
  for (int dy = -r; dy <= r; ++dy) {
    for (int dx = -r; dx <= r; ++dx) {
      if (dx * dx + dy * dy <= r * r && (dx != 0 || dy != 0)) window.push_back({dx, dy});
    }
  }
  return window;
}

template <typename Row>
void for_each_row(std::uint32_t height, const Row& row) {
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, height, 16),
                    [&](const tbb::blocked_range<std::uint32_t>& rows) {
                      for (std::uint32_t y = rows.begin(); y != rows.end(); ++y) row(static_cast<int>(y));
                    });
}

// Depths differ so little within a rectangle, kept inside the image, that no pair of them is an edge.
bool without_edges(std::span<const float> depth, int width, int height, int left, int top, int right, int bottom,
                   double depth_edge) {
  float least = std::numeric_limits<float>::infinity();
  float most = -least;
  bool finite = true;
  for (int y = std::max(top, 0); y < std::min(bottom, height); ++y) {
    const float* row = &depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(width)];
    for (int x = std::max(left, 0); x < std::min(right, width); ++x) {
      finite = finite && std::isfinite(row[x]);
      least = std::min(least, row[x]);
      most = std::max(most, row[x]);
    }
  }
  return finite && static_cast<double>(most - least) <= depth_edge * least;
}

// 1 where a sample may be used, before any fade.
std::vector<std::uint8_t> usable_pixels(const Photograph& photograph, std::span<const float> depth,
                                        const ValidityOptions& options) {
  constexpr int kBlock = 8;  // pixels a side that are looked at together first, for most have no edge near
  const std::vector<Shift> window = search_window(options.edge_radius_px);
  const int width = static_cast<int>(photograph.width);
  const int height = static_cast<int>(photograph.height);
  const int radius = static_cast<int>(options.edge_radius_px);
  std::vector<std::uint8_t> usable(depth.size());
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y) * photograph.width + static_cast<std::size_t>(x);
  };
  const auto away_from_edges = [&](int x, int y) {
    const float z = depth[at(x, y)];
    return std::isfinite(z) && std::all_of(window.begin(), window.end(), [&](const Shift& shift) {
             const int nx = x + shift.dx;
             const int ny = y + shift.dy;
             if (nx < 0 || ny < 0 || nx >= width || ny >= height) return true;
             const float neighbour = depth[at(nx, ny)];
             return static_cast<double>(std::abs(z - neighbour)) <= options.depth_edge * std::min(z, neighbour);
           });
  };
  for_each_row((photograph.height + kBlock - 1) / kBlock, [&](int block_row) {
    const int top = block_row * kBlock;
    for (int left = 0; left < width; left += kBlock) {
      const bool smooth = without_edges(depth, width, height, left - radius, top - radius, left + kBlock + radius,
                                        top + kBlock + radius, options.depth_edge);
      for (int y = top; y < std::min(top + kBlock, height); ++y) {
        for (int x = left; x < std::min(left + kBlock, width); ++x) {
          const bool in_lens = photograph.valid.empty() || photograph.valid[at(x, y)] != 0;
          usable[at(x, y)] = in_lens && (smooth || away_from_edges(x, y)) ? 1 : 0;
        }
      }
    }
  });
  return usable;
}

// Distance in pixels along the column to the nearest unusable pixel or the image's edge, at most `limit`.
std::vector<std::uint16_t> column_distances(const std::vector<std::uint8_t>& usable, std::size_t width,
                                            std::size_t height, int limit) {
  std::vector<std::uint16_t> distance(usable.size());
  const auto most = static_cast<std::uint16_t>(limit);
  std::vector<std::uint16_t> run(width, 0);
  const auto next = [&](std::size_t pixel, std::size_t x) {
    run[x] = usable[pixel] ? std::min(static_cast<std::uint16_t>(run[x] + 1), most) : std::uint16_t{0};
    return run[x];
  };
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) distance[y * width + x] = next(y * width + x, x);
  }
  std::fill(run.begin(), run.end(), std::uint16_t{0});
  for (std::size_t y = height; y-- > 0;) {
    for (std::size_t x = 0; x < width; ++x) {
      distance[y * width + x] = std::min(distance[y * width + x], next(y * width + x, x));
    }
  }
  return distance;
}

// The mask by the squared distance to the nearest unusable pixel: from 0 to 255 over `limit` pixels.
std::vector<std::uint8_t> rising_to(int limit) {
  std::vector<std::uint8_t> mask;
  for (int squared = 0; squared <= limit * limit; ++squared) {
    mask.push_back(static_cast<std::uint8_t>(std::lround(255.0 * std::min(1.0, std::sqrt(squared) / limit))));
  }
  return mask;
}

// The usable pixels' mask, rising over the fade.
std::vector<std::uint8_t> faded(const std::vector<std::uint8_t>& usable, const Photograph& photograph,
                                std::uint32_t fade_px) {
  const int width = static_cast<int>(photograph.width);
  // A pixel next to an unusable one is at distance 1 and gets the first step of the fade.
  const int limit = static_cast<int>(fade_px) + 1;
  const std::vector<std::uint16_t> column = column_distances(usable, photograph.width, photograph.height, limit);
  const std::vector<std::uint8_t> rising = rising_to(limit);
  std::vector<std::uint8_t> mask(usable.size());
  for_each_row(photograph.height, [&](int y) {
    const std::size_t row = static_cast<std::size_t>(y) * photograph.width;
    const auto along = [&](int x) { return x < 0 || x >= width ? 0 : int{column[row + static_cast<std::size_t>(x)]}; };
    int last_near = -1;  // of the columns up to x + limit, the last one with an unusable pixel in reach
    for (int x = 0; x < std::min(limit, width); ++x) last_near = along(x) < limit ? x : last_near;
    for (int x = 0; x < width; ++x) {
      if (along(x + limit) < limit) last_near = x + limit;
      int squared = limit * limit;
      for (int dx = -limit; last_near >= x - limit && dx <= limit; ++dx) {
        squared = std::min(squared, dx * dx + along(x + dx) * along(x + dx));
      }
      mask[row + static_cast<std::size_t>(x)] = rising[static_cast<std::size_t>(squared)];
    }
  });
  return mask;
}

void require_one_per_pixel(const char* field, std::size_t values, const Photograph& photograph, const char* or_else) {
  if (values == std::size_t{photograph.width} * photograph.height) return;
  throw std::invalid_argument(std::string("validity: ") + field + " has " + std::to_string(values) +
                              " values, must have one per pixel of the photograph" + or_else);
}

std::uint8_t trusted_by(std::uint8_t validity, std::uint8_t trust) {
  if (validity == 0) return 0;
  const int product = validity * std::max<int>(trust, 1);
  return static_cast<std::uint8_t>(std::max(1, (product + 127) / 255));  // 255 is odd: no ties to round
}

}  // namespace

ValidityOptions ValidityOptions::printed() {
  ValidityOptions options;
  options.fade_px = 0;
  return options;
}

void check(const ValidityOptions& options) {
  if (!(options.depth_edge > 0) || !std::isfinite(options.depth_edge)) {
    throw std::invalid_argument("validity: depth_edge is " + std::to_string(options.depth_edge) +
                                ", must be finite and above 0");
  }
  if (options.edge_radius_px > 16) {
    throw std::invalid_argument("validity: edge_radius_px is " + std::to_string(options.edge_radius_px) +
                                ", must be at most 16");
  }
  if (options.fade_px > 255) {
    throw std::invalid_argument("validity: fade_px is " + std::to_string(options.fade_px) + ", must be at most 255");
  }
}

std::vector<std::uint8_t> validity_mask(const Photograph& photograph, std::span<const float> depth,
                                        std::span<const std::uint8_t> trust, const ValidityOptions& options) {
  check(options);
  require_one_per_pixel("depth", depth.size(), photograph, "");
  if (!trust.empty()) require_one_per_pixel("trust", trust.size(), photograph, ", or none");
  std::vector<std::uint8_t> mask = faded(usable_pixels(photograph, depth, options), photograph, options.fade_px);
  if (!trust.empty()) std::transform(mask.begin(), mask.end(), trust.begin(), mask.begin(), trusted_by);
  return mask;
}

}  // namespace lumatlas
