// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/aligned_pictures.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

namespace lumatlas {
namespace {

constexpr std::uint32_t kColumns = 40, kRows = 20;

// Grey; rows from `wrong_from` on are wrong by 60 levels.
Photograph rows(std::uint32_t wrong_from) {
  Photograph image{kColumns, kRows, {}, {}};
  for (std::uint32_t i = 0; i < 3 * kColumns * kRows; ++i) {
    const std::uint32_t y = i / (3 * kColumns);
    image.rgb.push_back(static_cast<std::uint8_t>(100 + 5 * (i % 7) + (y < wrong_from ? 0 : 60)));
  }
  return image;
}

std::vector<std::uint8_t> rows_above(std::uint32_t end) {
  std::vector<std::uint8_t> seen(std::size_t{kColumns} * kRows, 0);
  for (std::uint32_t i = 0; i < kColumns * end; ++i) seen[i] = 1;
  return seen;
}

TEST_CASE("methods that show the same have the same aligned score, wherever the mesh is from their poses") {
  const Photograph photograph = rows(kRows);
  // One pose leaves out the rows that both show wrong.
  const std::vector<AlignedPicture> pictures = {{rows(15), {}, rows_above(14)}, {rows(15), {}, rows_above(kRows)}};
  const std::vector<std::uint8_t> common = seen_by_all(rows_above(kRows), pictures);
  std::vector<RegionScores> scores(2);
  for (std::size_t i = 0; i < 2; ++i) {
    add_aligned_scores(pictures[i].picture, photograph, common, scores[i]);
    REQUIRE(scores[i].aligned);
    CHECK(scores[i].aligned_pixels == kColumns * 14);
  }
  CHECK(scores[0].aligned->psnr == scores[1].aligned->psnr);
  CHECK(scores[0].aligned->ssim == scores[1].aligned->ssim);
}

TEST_CASE("what the given pose does not show of the mesh, or the lens not at all, does not count as aligned") {
  const std::vector<AlignedPicture> pictures = {{rows(kRows), {}, rows_above(kRows)}};
  const std::vector<std::uint8_t> common = seen_by_all(rows_above(12), pictures);
  Photograph photograph = rows(kRows);
  photograph.valid = rows_above(5);
  RegionScores scores;
  add_aligned_scores(pictures[0].picture, photograph, common, scores);
  CHECK(scores.aligned_pixels == kColumns * 5);
}

TEST_CASE("pictures that share no pixel have no aligned score") {
  const Photograph photograph = rows(kRows);
  const std::vector<AlignedPicture> pictures = {{photograph, {}, rows_above(0)}};
  RegionScores scores;
  add_aligned_scores(photograph, photograph, seen_by_all(rows_above(kRows), pictures), scores);
  CHECK(scores.aligned_pixels == 0);
  REQUIRE(scores.aligned);
  CHECK(std::isnan(scores.aligned->psnr));
}

TEST_CASE("aligned pictures of another size are refused") {
  const std::vector<AlignedPicture> pictures = {{rows(kRows), {}, std::vector<std::uint8_t>(3, 1)}};
  CHECK_THROWS_AS(seen_by_all(rows_above(kRows), pictures), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
