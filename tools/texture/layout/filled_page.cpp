// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/layout/filled_page.h"

#include <algorithm>
#include <utility>

#include "atlas/images/srgb.h"

namespace lumatlas {

namespace {

// Half the size; of each texel the mean of those of the four below it that are set.
void make_coarser(const Photograph& fine, const std::vector<std::uint8_t>& fine_set, Photograph& coarse,
                  std::vector<std::uint8_t>& coarse_set) {
  coarse.width = (fine.width + 1) / 2;
  coarse.height = (fine.height + 1) / 2;
  coarse.rgb.assign(3 * std::size_t{coarse.width} * coarse.height, 0);
  coarse_set.assign(std::size_t{coarse.width} * coarse.height, 0);
  for (std::uint32_t y = 0; y < coarse.height; ++y) {
    for (std::uint32_t x = 0; x < coarse.width; ++x) {
      std::uint32_t sum[3] = {0, 0, 0}, count = 0;
      for (std::uint32_t fy = 2 * y; fy < std::min(2 * y + 2, fine.height); ++fy) {
        for (std::uint32_t fx = 2 * x; fx < std::min(2 * x + 2, fine.width); ++fx) {
          const std::size_t texel = std::size_t{fy} * fine.width + fx;
          if (!fine_set[texel]) continue;
          ++count;
          for (std::size_t c = 0; c < 3; ++c) sum[c] += fine.rgb[3 * texel + c];
        }
      }
      if (count == 0) continue;
      const std::size_t texel = std::size_t{y} * coarse.width + x;
      coarse_set[texel] = 1;
      for (std::size_t c = 0; c < 3; ++c) {
        coarse.rgb[3 * texel + c] = static_cast<std::uint8_t>((sum[c] + count / 2) / count);
      }
    }
  }
}

void fill(Photograph& fine, std::vector<std::uint8_t>& fine_set) {
  if (fine.width <= 1 && fine.height <= 1) return;
  Photograph coarse;
  std::vector<std::uint8_t> coarse_set;
  make_coarser(fine, fine_set, coarse, coarse_set);
  fill(coarse, coarse_set);
  for (std::uint32_t y = 0; y < fine.height; ++y) {
    for (std::uint32_t x = 0; x < fine.width; ++x) {
      const std::size_t texel = std::size_t{y} * fine.width + x;
      if (fine_set[texel]) continue;
      std::copy_n(&coarse.rgb[3 * (std::size_t{y / 2} * coarse.width + x / 2)], 3, &fine.rgb[3 * texel]);
    }
  }
}

}  // namespace

FilledPage::FilledPage(std::uint32_t side_px)
    : picture_{side_px, side_px, std::vector<std::uint8_t>(3 * std::size_t{side_px} * side_px, 0), {}},
      is_set_(std::size_t{side_px} * side_px, 0) {}

void FilledPage::set(std::uint32_t x, std::uint32_t y, const glm::vec3& linear) {
  const std::size_t texel = std::size_t{y} * picture_.width + x;
  for (int c = 0; c < 3; ++c) {
    picture_.rgb[3 * texel + static_cast<std::size_t>(c)] = srgb8_from_linear(static_cast<double>(linear[c]));
  }
  is_set_[texel] = 1;
}

Photograph FilledPage::finish() {
  fill(picture_, is_set_);
  std::vector<std::uint8_t>().swap(is_set_);
  return std::exchange(picture_, {});
}

}  // namespace lumatlas
