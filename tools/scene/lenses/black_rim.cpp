// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/lenses/black_rim.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace lumatlas {

namespace {

constexpr std::uint8_t kDarkest = 12;       // largest value of a channel that was 0 before JPEG coded it
constexpr std::uint32_t kWidestShare = 10;  // a rim is at most one over this of the shorter side
constexpr std::int64_t kDarkened = 2;       // pixels beside the rim that are a mixture with it

class RimFinder {
 public:
  explicit RimFinder(const Photograph& photograph)
      : photograph_(photograph),
        width_(photograph.width),
        height_(photograph.height),
        widest_(std::min(photograph.width, photograph.height) / kWidestShare),
        rim_(std::size_t{photograph.width} * photograph.height, false) {}

  std::vector<bool> find() {
    for (std::int64_t x = 0; x < width_; ++x) {
      visit(x, 0);
      visit(x, height_ - 1);
    }
    for (std::int64_t y = 0; y < height_; ++y) {
      visit(0, y);
      visit(width_ - 1, y);
    }
    for (std::size_t next = 0; next < found_.size(); ++next) {
      const auto [x, y] = found_[next];
      visit(x - 1, y);
      visit(x + 1, y);
      visit(x, y - 1);
      visit(x, y + 1);
    }
    for (const Pixel& pixel : found_) darken_around(pixel);
    return std::move(rim_);
  }

 private:
  struct Pixel {
    std::int64_t x, y;
  };

  [[nodiscard]] std::size_t index(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>(y * width_ + x);
  }

  void visit(std::int64_t x, std::int64_t y) {
    if (x < 0 || y < 0 || x >= width_ || y >= height_ || rim_[index(x, y)]) return;
    if (std::min({x, y, width_ - 1 - x, height_ - 1 - y}) >= widest_) return;
    const std::uint8_t* const rgb = &photograph_.rgb[3 * index(x, y)];
    if (std::max({rgb[0], rgb[1], rgb[2]}) > kDarkest) return;
    rim_[index(x, y)] = true;
    found_.push_back({x, y});
  }

  void darken_around(const Pixel& pixel) {
    for (std::int64_t y = std::max<std::int64_t>(pixel.y - kDarkened, 0);
         y <= std::min(pixel.y + kDarkened, height_ - 1); ++y) {
      for (std::int64_t x = std::max<std::int64_t>(pixel.x - kDarkened, 0);
           x <= std::min(pixel.x + kDarkened, width_ - 1); ++x) {
        rim_[index(x, y)] = true;
      }
    }
  }

  const Photograph& photograph_;
  std::int64_t width_, height_, widest_;
  std::vector<bool> rim_;
  std::vector<Pixel> found_;
};

}  // namespace

std::vector<bool> black_rim(const Photograph& photograph) {
  return RimFinder(photograph).find();
}

}  // namespace lumatlas
