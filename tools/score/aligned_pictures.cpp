// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/aligned_pictures.h"

#include <cstddef>
#include <numeric>

#include "tools/score/measures/counted_pixels.h"

namespace lumatlas {

std::vector<std::uint8_t> seen_by_all(std::span<const std::uint8_t> at_given,
                                      std::span<const AlignedPicture> pictures) {
  std::vector<std::uint8_t> common(at_given.size());
  for (std::size_t i = 0; i < common.size(); ++i) common[i] = at_given[i] != 0 ? 1 : 0;
  for (const AlignedPicture& picture : pictures) {
    check_entries("the pixels of an aligned picture", picture.seen.size(), common.size());
    for (std::size_t i = 0; i < common.size(); ++i) {
      if (picture.seen[i] == 0) common[i] = 0;
    }
  }
  return common;
}

void add_aligned_scores(const Photograph& fitted, const Photograph& photograph, std::span<const std::uint8_t> mask,
                        RegionScores& scores) {
  const CountedPixels counted = counted_pixels(fitted, photograph, mask);
  scores.aligned_pixels = std::accumulate(counted.begin(), counted.end(), std::size_t{0});
  scores.aligned = Scores{psnr(fitted, photograph, counted), ssim(fitted, photograph, counted)};
}

}  // namespace lumatlas
