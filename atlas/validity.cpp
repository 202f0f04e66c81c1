// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/validity.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

struct Shift {
  int dx, dy;
  double length;
};

// SW(U) of section 3.1: the disc of whole-pixel shifts, nearest first.
std::vector<Shift> search_window(std::uint32_t radius) {
  std::vector<Shift> window;
  const int r = static_cast<int>(radius);
  for (int dy = -r; dy <= r; ++dy) {
    for (int dx = -r; dx <= r; ++dx) {
      const int squared = dx * dx + dy * dy;
      if (squared > 0 && squared <= r * r) window.push_back({dx, dy, std::sqrt(squared)});
    }
  }
  std::sort(window.begin(), window.end(), [](const Shift& a, const Shift& b) { return a.length < b.length; });
  return window;
}

template <typename Row>
void for_each_row(std::uint32_t height, const Row& row) {
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, height, 16),
                    [&](const tbb::blocked_range<std::uint32_t>& rows) {
                      for (std::uint32_t y = rows.begin(); y != rows.end(); ++y) row(static_cast<int>(y));
                    });
}

// Whether the depths of a rectangle, clipped to the image, differ so little that no two of them make an edge.
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

// The part of the validity masks that follows from depth edges alone.
class DepthEdges {
 public:
  DepthEdges(const Photograph& photograph, std::span<const float> depth, const ValidityOptions& options)
      : depth_(depth),
        width_(static_cast<int>(photograph.width)),
        height_(static_cast<int>(photograph.height)),
        options_(options) {}

  // 0 where no surface is.
  [[nodiscard]] std::vector<std::uint8_t> mask() const {
    const std::vector<Shift> edge_window = search_window(options_.edge_radius_px);
    const std::vector<std::uint8_t> usable = of_each_pixel(1, options_.edge_radius_px, [&](int x, int y) {
      return static_cast<std::uint8_t>(std::isfinite(depth_[at(x, y)]) && !edge_at(x, y, edge_window));
    });
    const std::vector<Shift> fade_window = search_window(options_.fade_px + 1);
    return of_each_pixel(255, options_.edge_radius_px + options_.fade_px + 1, [&](int x, int y) {
      return usable[at(x, y)] ? faded(x, y, usable, fade_window) : std::uint8_t{0};
    });
  }

  // 1 where a pixel within the radius is behind this one.
  [[nodiscard]] std::vector<std::uint8_t> rim() const {
    const std::vector<Shift> window = search_window(options_.edge_radius_px);
    return of_each_pixel(0, options_.edge_radius_px, [&](int x, int y) {
      const float z = depth_[at(x, y)];
      return static_cast<std::uint8_t>(std::any_of(window.begin(), window.end(), [&](const Shift& shift) {
        return inside(x + shift.dx, y + shift.dy) && is_edge(z, depth_[at(x + shift.dx, y + shift.dy)]);
      }));
    });
  }

 private:
  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }

  // `value` of each pixel, or `otherwise` where no edge is within `reach`.
  template <typename Value>
  [[nodiscard]] std::vector<std::uint8_t> of_each_pixel(std::uint8_t otherwise, std::uint32_t reach,
                                                        const Value& value) const {
    constexpr int kBlock = 8;  // pixels a side that are looked at together first, for most have no edge near
    const int around = static_cast<int>(reach);
    std::vector<std::uint8_t> values(depth_.size());
    for_each_row(static_cast<std::uint32_t>((height_ + kBlock - 1) / kBlock), [&](int block_row) {
      const int top = block_row * kBlock;
      for (int left = 0; left < width_; left += kBlock) {
        const bool smooth = without_edges(depth_, width_, height_, left - around, top - around, left + kBlock + around,
                                          top + kBlock + around, options_.depth_edge);
        for (int y = top; y < std::min(top + kBlock, height_); ++y) {
          for (int x = left; x < std::min(left + kBlock, width_); ++x) {
            values[at(x, y)] = smooth ? otherwise : value(x, y);
          }
        }
      }
    });
    return values;
  }

  [[nodiscard]] bool is_edge(float nearer, float farther) const {
    return static_cast<double>(farther - nearer) > options_.depth_edge * nearer;
  }

  // Whether a pixel in the window makes an edge, and this one is on a side of it that counts.
  [[nodiscard]] bool edge_at(int x, int y, const std::vector<Shift>& window) const {
    const float z = depth_[at(x, y)];
    const bool both = options_.edges == ValidityOptions::Edges::both_sides;
    return std::any_of(window.begin(), window.end(), [&](const Shift& shift) {
      if (!inside(x + shift.dx, y + shift.dy)) return false;
      const float other = depth_[at(x + shift.dx, y + shift.dy)];
      return is_edge(other, z) || (both && is_edge(z, other));
    });
  }

  // Rises with the distance from unusable pixels; where near sides are whole, from those that are not behind an edge.
  [[nodiscard]] std::uint8_t faded(int x, int y, const std::vector<std::uint8_t>& usable,
                                   const std::vector<Shift>& window) const {
    const float z = depth_[at(x, y)];
    const bool both = options_.edges == ValidityOptions::Edges::both_sides;
    const auto nearest = std::find_if(window.begin(), window.end(), [&](const Shift& shift) {
      if (!inside(x + shift.dx, y + shift.dy)) return false;
      const std::size_t other = at(x + shift.dx, y + shift.dy);
      return !usable[other] && (both || !is_edge(z, depth_[other]));
    });
    if (nearest == window.end()) return 255;
    return static_cast<std::uint8_t>(std::lround(255.0 * nearest->length / (options_.fade_px + 1)));
  }

  std::span<const float> depth_;
  int width_;
  int height_;
  const ValidityOptions& options_;
};

// 1 for pixels of which undistortion knows a colour: the lens shows something there.
std::vector<std::uint8_t> lens_image(const Photograph& photograph) {
  if (photograph.valid.empty()) return std::vector<std::uint8_t>(std::size_t{photograph.width} * photograph.height, 1);
  std::vector<std::uint8_t> usable(photograph.valid.size());
  std::transform(photograph.valid.begin(), photograph.valid.end(), usable.begin(),
                 [](std::uint8_t valid) { return static_cast<std::uint8_t>(valid != 0); });
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

// The mask of usable pixels, which rises from their border inwards over the length of the fade.
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
  options.edges = Edges::both_sides;
  return options;
}

std::string name_of(ValidityOptions::Edges edges) {
  return std::find_if(kEdgesByName.begin(), kEdgesByName.end(),
                      [&](const auto& known) { return known.second == edges; })
      ->first;
}

void check(const ValidityOptions& options) {
  if (!(options.depth_edge > 0) || !std::isfinite(options.depth_edge)) {
    throw std::invalid_argument("validity: depth_edge is " + number_text(options.depth_edge) +
                                ", must be finite and above 0");
  }
  if (options.edge_radius_px > 16) {
    throw std::invalid_argument("validity: edge_radius_px is " + std::to_string(options.edge_radius_px) +
                                ", must be at most 16");
  }
  if (options.fade_px > 16) {
    throw std::invalid_argument("validity: fade_px is " + std::to_string(options.fade_px) + ", must be at most 16");
  }
}

std::vector<std::uint8_t> validity_mask(const Photograph& photograph, std::span<const float> depth,
                                        std::span<const std::uint8_t> trust, const ValidityOptions& options) {
  check(options);
  require_one_per_pixel("depth", depth.size(), photograph, "");
  if (!photograph.valid.empty()) {
    require_one_per_pixel("photograph.valid", photograph.valid.size(), photograph, ", or none");
  }
  if (!trust.empty()) require_one_per_pixel("trust", trust.size(), photograph, ", or none");
  std::vector<std::uint8_t> mask = faded(lens_image(photograph), photograph, options.fade_px);
  const std::vector<std::uint8_t> edges = DepthEdges(photograph, depth, options).mask();
  std::transform(mask.begin(), mask.end(), edges.begin(), mask.begin(),
                 [](std::uint8_t a, std::uint8_t b) { return std::min(a, b); });
  if (!trust.empty()) std::transform(mask.begin(), mask.end(), trust.begin(), mask.begin(), trusted_by);
  return mask;
}

std::vector<std::uint8_t> rim_pixels(const Photograph& photograph, std::span<const float> depth,
                                     const ValidityOptions& options) {
  check(options);
  require_one_per_pixel("depth", depth.size(), photograph, "");
  if (options.edges == ValidityOptions::Edges::both_sides) return {};
  return DepthEdges(photograph, depth, options).rim();
}

}  // namespace lumatlas
