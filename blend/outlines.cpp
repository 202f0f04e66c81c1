// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/outlines.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/trigonometric.hpp>
#include <stdexcept>
#include <string>

#include "blend/soft_edges.h"

namespace lumatlas {

namespace {

void require_outline_pixels(std::size_t values, std::size_t pixels, const char* what) {
  if (values == pixels) return;
  throw std::invalid_argument("outlines: " + std::string(what) + " has " + std::to_string(values) +
                              " values, must have one for each of the " + std::to_string(pixels) + " pixels");
}

// The surface of a picture without what is continued.
class OutlinePicture {
 public:
  OutlinePicture(const Camera& camera, const VisibilityBuffer& visible, const std::vector<float>& deviation,
                 double most_deviation)
      : camera_(camera), visible_(visible), deviation_(deviation), most_deviation_(most_deviation) {}

  // The pixel whose surface (x, y) shows.
  [[nodiscard]] std::uint32_t shown_at(int x, int y) const {
    const std::uint32_t pixel = at(x, y);
    std::uint32_t from = pixel;
    if (!has_surface(pixel)) return from;
    for (int row = std::max(y - kOutlineReach, 0); row <= std::min(y + kOutlineReach, height() - 1); ++row) {
      for (int column = std::max(x - kOutlineReach, 0); column <= std::min(x + kOutlineReach, width() - 1); ++column) {
        const std::uint32_t other = at(column, row);
        if (!is_behind(pixel, other) || !reaches(other, pixel)) continue;
        if (from == pixel || comes_before(other, from, pixel)) from = other;
      }
    }
    return from;
  }

 private:
  [[nodiscard]] int width() const { return static_cast<int>(camera_.width); }
  [[nodiscard]] int height() const { return static_cast<int>(camera_.height); }
  [[nodiscard]] std::uint32_t at(int x, int y) const { return static_cast<std::uint32_t>(y * width() + x); }
  [[nodiscard]] bool has_surface(std::uint32_t pixel) const { return visible_.face[pixel] != FaceId::none; }

  [[nodiscard]] bool is_behind(std::uint32_t pixel, std::uint32_t other) const {
    return has_surface(other) &&
           static_cast<double>(visible_.depth[pixel]) > (1 + kOutlineStep) * static_cast<double>(visible_.depth[other]);
  }

  [[nodiscard]] int squared_distance(std::uint32_t a, std::uint32_t b) const {
    const auto row = camera_.width;
    const int dx = static_cast<int>(a % row) - static_cast<int>(b % row);
    const int dy = static_cast<int>(a / row) - static_cast<int>(b / row);
    return dx * dx + dy * dy;
  }

  [[nodiscard]] bool reaches(std::uint32_t from, std::uint32_t pixel) const {
    const double off = std::min(static_cast<double>(deviation_[from]), most_deviation_);
    const double shift =
        off * std::sin(glm::radians(kSoftEdgeDegrees)) * camera_.fx / static_cast<double>(visible_.depth[from]);
    const double reach = shift > 1 ? std::min(kOutlineOfShift * shift, double{kOutlineReach}) : 0;
    return squared_distance(from, pixel) <= reach * reach;
  }

  [[nodiscard]] bool comes_before(std::uint32_t a, std::uint32_t b, std::uint32_t pixel) const {
    const int of_a = squared_distance(a, pixel), of_b = squared_distance(b, pixel);
    return of_a < of_b || (of_a == of_b && visible_.depth[a] < visible_.depth[b]);
  }

  const Camera& camera_;
  const VisibilityBuffer& visible_;
  const std::vector<float>& deviation_;
  double most_deviation_;
};

}  // namespace

std::vector<std::uint32_t> continued_outlines(const Camera& camera, const VisibilityBuffer& visible,
                                              const std::vector<float>& deviation, double most_deviation) {
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  require_outline_pixels(visible.depth.size(), pixels, "the depth");
  require_outline_pixels(visible.face.size(), pixels, "the surface");
  require_outline_pixels(deviation.size(), pixels, "the deviation");
  const OutlinePicture picture(camera, visible, deviation, most_deviation);
  std::vector<std::uint32_t> from;
  from.reserve(pixels);
  for (int y = 0; y < static_cast<int>(camera.height); ++y) {
    for (int x = 0; x < static_cast<int>(camera.width); ++x) from.push_back(picture.shown_at(x, y));
  }
  return from;
}

}  // namespace lumatlas
