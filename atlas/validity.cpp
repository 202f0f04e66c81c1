// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/validity.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
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

// 1 where a sample may be used, before any fade.
std::vector<std::uint8_t> usable_pixels(const Photograph& photograph, std::span<const float> depth,
                                        const ValidityOptions& options) {
  const std::vector<Shift> window = search_window(options.edge_radius_px);
  const int width = static_cast<int>(photograph.width);
  const int height = static_cast<int>(photograph.height);
  std::vector<std::uint8_t> usable(depth.size());
  for_each_row(photograph.height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * photograph.width + static_cast<std::size_t>(x);
      const float z = depth[pixel];
      bool good = std::isfinite(z) && (photograph.valid.empty() || photograph.valid[pixel] != 0);
      for (std::size_t i = 0; good && i < window.size(); ++i) {
        const int nx = x + window[i].dx;
        const int ny = y + window[i].dy;
        if (nx < 0 || ny < 0 || nx >= width || ny >= height) continue;
        const float neighbour = depth[static_cast<std::size_t>(ny) * photograph.width + static_cast<std::size_t>(nx)];
        good = static_cast<double>(std::abs(z - neighbour)) <= options.depth_edge * std::min(z, neighbour);
      }
      usable[pixel] = good ? 1 : 0;
    }
  });
  return usable;
}

// Distance in pixels along the column to the nearest unusable pixel or the image's edge, at most `limit`.
std::vector<std::uint16_t> column_distances(const std::vector<std::uint8_t>& usable, int width, int height, int limit) {
  std::vector<std::uint16_t> distance(usable.size());
  const auto at = [&](int x, int y) { return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + x; };
  for (int x = 0; x < width; ++x) {
    int run = 0;
    for (int y = 0; y < height; ++y) {
      run = usable[at(x, y)] ? std::min(run + 1, limit) : 0;
      distance[at(x, y)] = static_cast<std::uint16_t>(run);
    }
    run = 0;
    for (int y = height - 1; y >= 0; --y) {
      run = usable[at(x, y)] ? std::min(run + 1, limit) : 0;
      distance[at(x, y)] = std::min(distance[at(x, y)], static_cast<std::uint16_t>(run));
    }
  }
  return distance;
}

void require_one_per_pixel(const char* field, std::size_t values, const Photograph& photograph, const char* or_else) {
  if (values == std::size_t{photograph.width} * photograph.height) return;
  throw std::invalid_argument(std::string("validity: ") + field + " has " + std::to_string(values) +
                              " values, must have one per pixel of the photograph" + or_else);
}

// The usable pixels' mask, rising over the fade.
std::vector<std::uint8_t> faded(const std::vector<std::uint8_t>& usable, const Photograph& photograph,
                                std::uint32_t fade_px) {
  const int width = static_cast<int>(photograph.width);
  const int height = static_cast<int>(photograph.height);
  // A pixel next to an unusable one is at distance 1 and gets the first step of the fade.
  const int limit = static_cast<int>(fade_px) + 1;
  const std::vector<std::uint16_t> column = column_distances(usable, width, height, limit);
  std::vector<std::uint8_t> mask(usable.size());
  for_each_row(photograph.height, [&](int y) {
    const std::size_t row = static_cast<std::size_t>(y) * photograph.width;
    for (int x = 0; x < width; ++x) {
      int squared = limit * limit;
      for (int dx = -limit; dx <= limit; ++dx) {
        const int nx = x + dx;
        const int along = nx < 0 || nx >= width ? 0 : column[row + static_cast<std::size_t>(nx)];
        squared = std::min(squared, dx * dx + along * along);
      }
      mask[row + static_cast<std::size_t>(x)] =
          static_cast<std::uint8_t>(std::lround(255.0 * std::min(1.0, std::sqrt(squared) / limit)));
    }
  });
  return mask;
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
