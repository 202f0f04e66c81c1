// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/scaled_view.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "atlas/images/srgb.h"
#include "atlas/tiles/tiles.h"

namespace lumatlas {

namespace {

// A size loses this before it is rounded up, because rounding errors may make a whole number larger. page/model.js has
// the same number.
constexpr double kRounding = 1e-9;

// The pixels that one of a scaled picture covers along an axis, and how much of each.
struct Span {
  std::uint32_t first = 0;
  std::vector<double> shares;
};

std::vector<Span> spans(std::uint32_t pixels, std::uint32_t scaled, double factor) {
  std::vector<Span> result(scaled);
  for (std::uint32_t i = 0; i < scaled; ++i) {
    const double from = std::min(i / factor, pixels - 1.0);
    const double to = std::clamp((i + 1) / factor, from, static_cast<double>(pixels));
    result[i].first = static_cast<std::uint32_t>(from);
    for (std::uint32_t pixel = result[i].first; pixel < to; ++pixel) {
      result[i].shares.push_back(std::min(to, pixel + 1.0) - std::max<double>(from, pixel));
    }
  }
  return result;
}

class Scaling {
 public:
  Scaling(const StoredView& view, double factor, bool by_validity) : view_(view), by_validity_(by_validity) {
    result_.width = static_cast<std::uint32_t>(std::ceil(view.camera.width * factor - kRounding));
    result_.height = static_cast<std::uint32_t>(std::ceil(view.camera.height * factor - kRounding));
    across_ = spans(view.camera.width, result_.width, factor);
    down_ = spans(view.camera.height, result_.height, factor);
    result_.photograph.width = result_.width;
    result_.photograph.height = result_.height;
    const std::size_t pixels = std::size_t{result_.width} * result_.height;
    result_.photograph.rgb.resize(3 * pixels);
    result_.validity.resize(pixels);
    result_.rim.resize(pixels);
  }

  ScaledView run() {
    tbb::parallel_for(0u, result_.height, [&](std::uint32_t y) {
      for (std::uint32_t x = 0; x < result_.width; ++x) fill(x, y);
    });
    return std::move(result_);
  }

 private:
  // The sum over the pixels of one scaled pixel, by their area and, if that is asked for, validity.
  [[nodiscard]] std::array<double, 4> sum(const Span& across, const Span& down, bool by_validity) const {
    const auto& linear = linear_from_srgb8();
    std::array<double, 4> total{};
    for (std::size_t row = 0; row < down.shares.size(); ++row) {
      for (std::size_t column = 0; column < across.shares.size(); ++column) {
        const std::size_t pixel = (down.first + row) * view_.camera.width + across.first + column;
        const double weight =
            down.shares[row] * across.shares[column] * (by_validity ? view_.mask->validity[pixel] / 255.0 : 1.0);
        const StoredPhotograph::Color color = view_.photograph->color(pixel);
        for (std::size_t channel = 0; channel < 3; ++channel) total.at(channel) += weight * linear[color.at(channel)];
        total[3] += weight;
      }
    }
    return total;
  }

  void fill(std::uint32_t x, std::uint32_t y) {
    const Span& across = across_[x];
    const Span& down = down_[y];
    const std::size_t pixel = std::size_t{y} * result_.width + x;
    std::array<double, 4> valid = sum(across, down, by_validity_);
    const std::array<double, 4> all = by_validity_ ? sum(across, down, false) : valid;
    result_.validity[pixel] = static_cast<std::uint8_t>(std::lround(255 * valid[3] / all[3]));
    if (!(valid[3] > 0)) valid = all;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      result_.photograph.rgb[3 * pixel + channel] = srgb8_from_linear(valid.at(channel) / valid[3]);
    }
    const std::size_t middle =
        (down.first + down.shares.size() / 2) * view_.camera.width + across.first + across.shares.size() / 2;
    result_.rim[pixel] = view_.mask->at_rim(middle) ? 1 : 0;
  }

  const StoredView& view_;
  bool by_validity_;
  std::vector<Span> across_, down_;
  ScaledView result_;
};

// Pixels that are not known get the mean of those neighbours that are, ring by ring.
void fill_from_neighbours(Photograph& picture, std::vector<std::uint8_t> known) {
  const auto width = static_cast<std::ptrdiff_t>(picture.width);
  const auto height = static_cast<std::ptrdiff_t>(picture.height);
  bool filled = std::count(known.begin(), known.end(), 0) > 0;
  while (filled) {
    filled = false;
    const std::vector<std::uint8_t> before = known;
    for (std::ptrdiff_t pixel = 0; pixel < width * height; ++pixel) {
      if (before[static_cast<std::size_t>(pixel)]) continue;
      std::array<unsigned, 3> sum{};
      unsigned count = 0;
      for (std::ptrdiff_t y = std::max<std::ptrdiff_t>(pixel / width - 1, 0);
           y <= std::min(pixel / width + 1, height - 1); ++y) {
        for (std::ptrdiff_t x = std::max<std::ptrdiff_t>(pixel % width - 1, 0);
             x <= std::min(pixel % width + 1, width - 1); ++x) {
          const auto other = static_cast<std::size_t>(y * width + x);
          if (!before[other]) continue;
          for (std::size_t channel = 0; channel < 3; ++channel) sum.at(channel) += picture.rgb[3 * other + channel];
          ++count;
        }
      }
      if (count == 0) continue;
      for (std::size_t channel = 0; channel < 3; ++channel) {
        picture.rgb[3 * static_cast<std::size_t>(pixel) + channel] = static_cast<std::uint8_t>(sum.at(channel) / count);
      }
      known[static_cast<std::size_t>(pixel)] = 1;
      filled = true;
    }
  }
}

}  // namespace

ScaledView scaled_view(const StoredView& view, double factor) {
  if (!(factor > 0 && factor <= 1)) {
    throw std::invalid_argument("scaled view: the factor is " + std::to_string(factor) + ", must be in (0, 1]");
  }
  if (factor < 1) return Scaling(view, factor, true).run();
  ScaledView same{view.camera.width, view.camera.height, view.photograph->whole(), view.mask->validity.all(),
                  view.mask->rim.all()};
  same.rim.resize(view.mask->validity.size(), 0);
  return same;
}

Photograph small_picture(const StoredView& view, std::uint32_t longest_px, std::span<const std::uint8_t> tiles_there,
                         std::uint32_t tile_px) {
  const double longest = std::max(view.camera.width, view.camera.height);
  Photograph small = Scaling(view, std::min(1.0, longest_px / longest), false).run().photograph;
  if (tiles_there.empty()) return small;
  std::vector<std::uint8_t> known;
  const TileGrid grid(view.camera.width, view.camera.height, tile_px);
  for (std::uint32_t y = 0; y < small.height; ++y) {
    for (std::uint32_t x = 0; x < small.width; ++x) {
      const std::uint32_t column = (2 * x + 1) * view.camera.width / (2 * small.width) / tile_px;
      const std::uint32_t row = (2 * y + 1) * view.camera.height / (2 * small.height) / tile_px;
      known.push_back(tiles_there[std::size_t{row} * grid.columns + column]);
    }
  }
  fill_from_neighbours(small, std::move(known));
  return small;
}

}  // namespace lumatlas
