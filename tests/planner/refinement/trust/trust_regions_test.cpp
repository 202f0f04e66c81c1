// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/trust/trust_regions.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <functional>
#include <numeric>

namespace lumatlas {
namespace {

constexpr std::uint32_t kWidth = 40, kHeight = 30;

struct BlockRect {
  std::uint32_t left, top, right, bottom;

  [[nodiscard]] bool contains(std::size_t block) const {
    const std::size_t x = block % kWidth, y = block / kWidth;
    return x >= left && x < right && y >= top && y < bottom;
  }
  [[nodiscard]] BlockRect grown(std::uint32_t by) const { return {left - by, top - by, right + by, bottom + by}; }
};

using Judge = std::function<Judgement(std::size_t)>;

// A grey wall with a red coat before it.
TrustGrid coat_before_wall(const BlockRect& coat) {
  TrustGrid grid{kWidth, kHeight, {}, {}, {}};
  for (std::size_t block = 0; block < grid.size(); ++block) {
    grid.color.push_back(coat.contains(block) ? glm::dvec3(0.7, 0.1, 0.1) : glm::dvec3(0.5));
  }
  grid.low = grid.color;
  grid.high = grid.color;
  return grid;
}

// Checks that those blocks get little trust that the rectangle has, and no others.
void check_is(const std::vector<std::uint8_t>& found, const BlockRect& expected) {
  REQUIRE(found.size() == std::size_t{kWidth} * kHeight);
  for (std::size_t block = 0; block < found.size(); ++block) {
    INFO("block " << block % kWidth << ", " << block / kWidth);
    REQUIRE((found[block] != 0) == expected.contains(block));
  }
}

constexpr BlockRect kCoat{10, 8, 22, 24};
constexpr BlockRect kContradicted{10, 8, 22, 14};  // the part of it that others say something of

// `coat` and `wall`: what is said of their blocks that are not contradicted.
Judge judging(const BlockRect& contradicted, Judgement coat, Judgement wall) {
  return [=](std::size_t block) {
    if (contradicted.contains(block)) return Judgement::contradicted;
    return kCoat.contains(block) ? coat : wall;
  };
}

TEST_CASE("a contradicted rectangle loses its trust with one block around it") {
  const TrustGrid grid = coat_before_wall(kCoat);
  const std::vector<std::uint8_t> found =
      contradicted_regions(grid, judging(kCoat, Judgement::trusted, Judgement::trusted), TrustExtent::regions);
  // Four blocks of nine are contradicted around a corner: too few, but the rest grows over them.
  check_is(found, kCoat.grown(1));
}

TEST_CASE("blocks that are contradicted alone or in a row keep their trust") {
  const TrustGrid grid = coat_before_wall(kCoat);
  const Judge lone = [](std::size_t block) {
    const std::size_t x = block % kWidth, y = block / kWidth;
    return (x == 7 && y == 9) || y == 20 ? Judgement::contradicted : Judgement::trusted;
  };
  const std::vector<std::uint8_t> found = contradicted_regions(grid, lone, TrustExtent::regions);
  CHECK(std::accumulate(found.begin(), found.end(), 0) == 0);
}

TEST_CASE("what is contradicted grows over doubtful blocks, three at most, and not over doubtful ones elsewhere") {
  const TrustGrid grid = coat_before_wall(kContradicted);
  const Judge judge = [](std::size_t block) {
    if (kContradicted.contains(block)) return Judgement::contradicted;
    return block / kWidth >= 14 ? Judgement::doubtful : Judgement::trusted;  // all below
  };
  const std::vector<std::uint8_t> found = contradicted_regions(grid, judge, TrustExtent::regions);
  const auto is_found = [&](std::uint32_t x, std::uint32_t y) { return found[std::size_t{y} * kWidth + x] != 0; };
  CHECK(is_found(15, 14 + kDoubtfulReach));  // by one block more, as all that counts
  CHECK_FALSE(is_found(15, 15 + kDoubtfulReach));
  CHECK_FALSE(is_found(35, 25));
  CHECK_FALSE(is_found(15, 6));
}

TEST_CASE("a coat is judged as a whole where no other view shows what is behind some of it") {
  const TrustGrid grid = coat_before_wall(kCoat);
  SECTION("the wall is trusted") {
    check_is(contradicted_regions(grid, judging(kContradicted, Judgement::unknown, Judgement::trusted),
                                  TrustExtent::regions),
             kCoat.grown(1));
  }
  SECTION("the wall is unknown, and has another colour") {
    check_is(contradicted_regions(grid, judging(kContradicted, Judgement::unknown, Judgement::unknown),
                                  TrustExtent::regions),
             kCoat.grown(1));
  }
}

TEST_CASE("a segment of which others show a part keeps its trust where nothing is known") {
  const TrustGrid grid = coat_before_wall(kCoat);
  const BlockRect trusted{10, 20, 22, 24};
  REQUIRE(std::size_t{72} < kVotes * 48);  // contradicted and trusted blocks
  const Judge judge = [&](std::size_t block) {
    if (trusted.contains(block)) return Judgement::trusted;
    return judging(kContradicted, Judgement::unknown, Judgement::trusted)(block);
  };
  check_is(contradicted_regions(grid, judge, TrustExtent::regions), kContradicted.grown(1));
}

TEST_CASE("a wall whose surface is wrong in one place keeps its trust elsewhere") {
  const TrustGrid grid = coat_before_wall({0, 0, 0, 0});
  const Judge judge = [](std::size_t block) {
    if (kContradicted.contains(block)) return Judgement::contradicted;
    return block % 2 ? Judgement::unknown : Judgement::trusted;
  };
  check_is(contradicted_regions(grid, judge, TrustExtent::regions), kContradicted.grown(1));
}

TEST_CASE("a thin strip of contradictions does not grow") {
  const TrustGrid grid = coat_before_wall({0, 0, 0, 0});
  for (const std::uint32_t width : {kThick - 1, kThick}) {
    const BlockRect strip{10, 5, 10 + width, 25};
    const Judge judge = [=](std::size_t block) {
      return strip.contains(block) ? Judgement::contradicted : Judgement::doubtful;
    };
    const std::vector<std::uint8_t> found = contradicted_regions(grid, judge, TrustExtent::regions);
    const std::size_t beside = std::size_t{15} * kWidth + strip.right + 1;
    CHECK((found[beside] != 0) == (width == kThick));
  }
}

TEST_CASE("while poses are refined, what is contradicted is not completed") {
  const TrustGrid grid = coat_before_wall(kCoat);
  for (const Judgement coat : {Judgement::unknown, Judgement::doubtful}) {
    const std::vector<std::uint8_t> found =
        contradicted_regions(grid, judging(kContradicted, coat, Judgement::trusted), TrustExtent::blocks);
    const BlockRect beyond{0, kContradicted.bottom + 1, kWidth, kHeight};
    std::size_t completed = 0;
    for (std::size_t block = 0; block < found.size(); ++block) completed += beyond.contains(block) && found[block] != 0;
    CHECK(completed == 0);
  }
}

TEST_CASE("blocks are judged at most once, and few of them where nothing is contradicted") {
  const TrustGrid grid = coat_before_wall(kCoat);
  std::vector<std::atomic<int>> judged(grid.size());
  const auto most = [&] {
    return std::max_element(judged.begin(), judged.end(), [](const auto& a, const auto& b) { return a < b; })->load();
  };
  (void)contradicted_regions(
      grid,
      [&](std::size_t block) {
        ++judged[block];
        return kContradicted.contains(block) ? Judgement::contradicted : Judgement::unknown;
      },
      TrustExtent::regions);
  CHECK(most() == 1);
  for (std::atomic<int>& count : judged) count = 0;
  (void)contradicted_regions(
      grid,
      [&](std::size_t block) {
        ++judged[block];
        return Judgement::trusted;
      },
      TrustExtent::regions);
  CHECK(std::accumulate(judged.begin(), judged.end(), std::size_t{0}) <= grid.size() * 5 / 9 + kWidth + kHeight);
}

}  // namespace
}  // namespace lumatlas
