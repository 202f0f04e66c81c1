// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/views/validity.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

struct Shift {
  int dx, dy;
  double length;
};

// The disc of whole-pixel shifts, nearest first.
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

// SW(U) of section 3.1, the disc of that radius: half the width, in pixels, of each of its rows, from the topmost one.
std::vector<int> half_widths(std::uint32_t radius) {
  const int r = static_cast<int>(radius);
  std::vector<int> widths;
  for (int dy = -r; dy <= r; ++dy) {
    int width = r;
    while (width * width + dy * dy > r * r) --width;
    widths.push_back(width);
  }
  return widths;
}

// The mask of a usable pixel at that distance from the nearest unusable one, for a fade of at least 1 pixel. It is next
// to nothing right beside that one: drawn with linear interpolation, the mask then ends at the edge between the two.
std::uint8_t faded_to(double distance_px, std::uint32_t fade_px) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(255 * (distance_px - 1) / fade_px), 1L, 255L));
}

// The part of the validity masks that follows from depth edges alone.
class DepthEdges {
 public:
  DepthEdges(const Photograph& photograph, std::span<const float> depth, const ValidityOptions& options)
      : depth_(depth),
        width_(static_cast<int>(photograph.width)),
        height_(static_cast<int>(photograph.height)),
        options_(options),
        half_widths_(half_widths(options.edge_radius_px)) {}

  // 0 where no surface is.
  [[nodiscard]] std::vector<std::uint8_t> mask() const {
    const bool both = options_.edges == ValidityOptions::Edges::both_sides;
    const std::vector<std::uint8_t> usable = of_each_row([&](int y, std::uint8_t* values) {
      const std::vector<float> nearest = extremes_around(y, std::less<>());
      const std::vector<float> farthest = both ? extremes_around(y, std::greater<>()) : std::vector<float>();
      for (int x = 0; x < width_; ++x) {
        const float z = depth_[at(x, y)];
        const auto i = static_cast<std::size_t>(x);
        const bool at_edge = is_edge(nearest[i], z) || (both && is_edge(z, farthest[i]));
        values[x] = std::isfinite(z) && !at_edge ? 255 : 0;
      }
    });
    return options_.fade_px == 0 ? usable : faded(usable);
  }

  // 1 where a pixel within the radius is behind this one.
  [[nodiscard]] std::vector<std::uint8_t> rim() const {
    return of_each_row([&](int y, std::uint8_t* values) {
      const std::vector<float> farthest = extremes_around(y, std::greater<>());
      for (int x = 0; x < width_; ++x) values[x] = is_edge(depth_[at(x, y)], farthest[static_cast<std::size_t>(x)]);
    });
  }

 private:
  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }

  // `fill` gets each row's number and its first value.
  template <typename Fill>
  [[nodiscard]] std::vector<std::uint8_t> of_each_row(const Fill& fill) const {
    std::vector<std::uint8_t> values(depth_.size());
    for_each_row(static_cast<std::uint32_t>(height_), [&](int y) { fill(y, values.data() + at(0, y)); });
    return values;
  }

  // Returns for each pixel of a row the depth within the radius that comes before all others. An edge with any of them
  // is an edge with this one, which is found faster for whole rows than for each pixel.
  template <typename Before>
  [[nodiscard]] std::vector<float> extremes_around(int y, const Before& before) const {
    const float* middle = depth_.data() + at(0, y);
    std::vector<float> extremes(middle, middle + width_);
    const int radius = static_cast<int>(options_.edge_radius_px);
    for (int dy = -radius; dy <= radius; ++dy) {
      if (y + dy < 0 || y + dy >= height_) continue;
      const float* row = depth_.data() + at(0, y + dy);
      const auto line = static_cast<std::uint32_t>(dy + radius);
      const int half = half_widths_[line];
      for (int dx = -half; dx <= half; ++dx) {
        float* extreme = extremes.data();
        const int end = width_ - std::max(dx, 0);
        for (int x = std::max(-dx, 0); x < end; ++x) {
          extreme[x] = before(row[x + dx], extreme[x]) ? row[x + dx] : extreme[x];
        }
      }
    }
    return extremes;
  }

  [[nodiscard]] bool is_edge(float nearer, float farther) const {
    return static_cast<double>(farther - nearer) > options_.depth_edge * nearer;
  }

  // The mask without a fade, 255 or 0, with one.
  [[nodiscard]] std::vector<std::uint8_t> faded(const std::vector<std::uint8_t>& usable) const {
    const std::vector<Shift> window = search_window(options_.fade_px + 1);
    const int reach = static_cast<int>(options_.fade_px) + 1;
    constexpr int kBlock = 8;  // pixels a side that are looked at together first, for most have no edge near
    std::vector<std::uint8_t> mask(usable.size());
    for_each_row(static_cast<std::uint32_t>((height_ + kBlock - 1) / kBlock), [&](int block_row) {
      const int top = block_row * kBlock, bottom = std::min(top + kBlock, height_);
      for (int left = 0; left < width_; left += kBlock) {
        const int right = std::min(left + kBlock, width_);
        const bool whole = all_usable(usable, left - reach, top - reach, right + reach, bottom + reach);
        for (int y = top; y < bottom; ++y) {
          for (int x = left; x < right; ++x) mask[at(x, y)] = whole ? 255 : faded(x, y, usable, window);
        }
      }
    });
    return mask;
  }

  // In a rectangle, clipped to the image.
  [[nodiscard]] bool all_usable(const std::vector<std::uint8_t>& usable, int left, int top, int right,
                                int bottom) const {
    for (int y = std::max(top, 0); y < std::min(bottom, height_); ++y) {
      const auto row = usable.begin() + static_cast<std::ptrdiff_t>(at(0, y));
      if (std::find(row + std::max(left, 0), row + std::min(right, width_), 0) != row + std::min(right, width_)) {
        return false;
      }
    }
    return true;
  }

  // Rises with the distance from unusable pixels; where near sides are whole, from those that are not behind an edge.
  [[nodiscard]] std::uint8_t faded(int x, int y, const std::vector<std::uint8_t>& usable,
                                   const std::vector<Shift>& window) const {
    if (!usable[at(x, y)]) return 0;
    const float z = depth_[at(x, y)];
    const bool both = options_.edges == ValidityOptions::Edges::both_sides;
    const auto nearest = std::find_if(window.begin(), window.end(), [&](const Shift& shift) {
      if (!inside(x + shift.dx, y + shift.dy)) return false;
      const std::size_t other = at(x + shift.dx, y + shift.dy);
      return !usable[other] && (both || !is_edge(z, depth_[other]));
    });
    if (nearest == window.end()) return 255;
    return faded_to(nearest->length, options_.fade_px);
  }

  std::span<const float> depth_;
  int width_;
  int height_;
  const ValidityOptions& options_;
  std::vector<int> half_widths_;
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

// The mask by the squared distance to the nearest unusable pixel, up to one more than the fade's length.
std::vector<std::uint8_t> rising_over(std::uint32_t fade_px) {
  const auto limit = static_cast<int>(fade_px) + 1;
  std::vector<std::uint8_t> mask{0};
  for (int squared = 1; squared <= limit * limit; ++squared) mask.push_back(faded_to(std::sqrt(squared), fade_px));
  return mask;
}

std::vector<std::uint8_t> rising_at_once(const std::vector<std::uint8_t>& usable) {
  std::vector<std::uint8_t> mask(usable.size());
  std::transform(usable.begin(), usable.end(), mask.begin(),
                 [](std::uint8_t is_usable) { return static_cast<std::uint8_t>(is_usable ? 255 : 0); });
  return mask;
}

// The mask of usable pixels, which rises from their border inwards over the length of the fade.
std::vector<std::uint8_t> faded(const std::vector<std::uint8_t>& usable, const Photograph& photograph,
                                std::uint32_t fade_px) {
  if (fade_px == 0) return rising_at_once(usable);
  const int width = static_cast<int>(photograph.width);
  const int limit = static_cast<int>(fade_px) + 1;
  const std::vector<std::uint16_t> column = column_distances(usable, photograph.width, photograph.height, limit);
  const std::vector<std::uint8_t> rising = rising_over(fade_px);
  std::vector<std::uint8_t> mask(usable.size());
  for_each_row(photograph.height, [&](int y) {
    const std::size_t row = static_cast<std::size_t>(y) * photograph.width;
    const auto along = [&](int x) { return x < 0 || x >= width ? 0 : int{column[row + static_cast<std::size_t>(x)]}; };
    int last_near = -1;  // the last column up to x + limit that has an unusable pixel in reach
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
  if (!(options.depth_edge > 0 && options.depth_edge <= kMostDepthEdge)) {
    throw std::invalid_argument("validity: depth_edge is " + number_text(options.depth_edge) +
                                ", must be above 0 and at most " + number_text(kMostDepthEdge));
  }
  if (options.edge_radius_px > kMostEdgePixels) {
    throw std::invalid_argument("validity: edge_radius_px is " + std::to_string(options.edge_radius_px) +
                                ", must be at most " + std::to_string(kMostEdgePixels));
  }
  if (options.fade_px > kMostEdgePixels) {
    throw std::invalid_argument("validity: fade_px is " + std::to_string(options.fade_px) + ", must be at most " +
                                std::to_string(kMostEdgePixels));
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
