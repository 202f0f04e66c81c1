// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/trust/trust_regions.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <glm/common.hpp>

namespace lumatlas {

namespace {

constexpr int kNeighboursAgreeing = 5;  // among the 3x3 blocks around one, itself included

// Calls visit(block) for the 3x3 blocks around one, itself included, that the grid has.
template <typename Visit>
void around(const TrustGrid& grid, std::uint32_t x, std::uint32_t y, const Visit& visit) {
  for (std::uint32_t ny = y - (y > 0); ny <= std::min(y + 1, grid.height - 1); ++ny) {
    for (std::uint32_t nx = x - (x > 0); nx <= std::min(x + 1, grid.width - 1); ++nx) {
      visit(std::size_t{ny} * grid.width + nx);
    }
  }
}

// Calls visit(x, y, block) for all blocks, row by row.
template <typename Visit>
void for_each_block(const TrustGrid& grid, const Visit& visit) {
  for (std::uint32_t y = 0; y < grid.height; ++y) {
    for (std::uint32_t x = 0; x < grid.width; ++x) visit(x, y, std::size_t{y} * grid.width + x);
  }
}

// Returns 1 where at least `least` of the 3x3 blocks around are meant.
template <typename IsMeant>
std::vector<std::uint8_t> counted_around(const TrustGrid& grid, int least, const IsMeant& is_meant) {
  std::vector<std::uint8_t> result(grid.size(), 0);
  for_each_block(grid, [&](std::uint32_t x, std::uint32_t y, std::size_t block) {
    int count = 0;
    around(grid, x, y, [&](std::size_t neighbour) { count += is_meant(neighbour); });
    result[block] = count >= least;
  });
  return result;
}

// Judgements that are made when they are needed.
class Regions {
 public:
  Regions(const TrustGrid& grid, const std::function<Judgement(std::size_t)>& judge)
      : grid_(grid), judge_(judge), judgements_(grid.size(), Judgement::unjudged) {}

  [[nodiscard]] std::vector<std::uint8_t> found(TrustExtent extent) {
    judge_what_may_count();
    counts_ = counted_around(grid_, kNeighboursAgreeing,
                             [&](std::size_t block) { return judgements_[block] == Judgement::contradicted; });
    if (extent == TrustExtent::regions) complete_occluders();
    return counted_around(grid_, 1, [&](std::size_t block) { return counts_[block] != 0; });
  }

 private:
  void complete_occluders() {
    occluder_ = with_square();
    for (int step = 0; step < kDoubtfulReach; ++step) grow_over_doubtful();
    complete_segments();
    for (std::size_t block = 0; block < grid_.size(); ++block) {
      if (occluder_[block]) counts_[block] = 1;
    }
  }

  Judgement at(std::size_t block) {
    if (judgements_[block] == Judgement::unjudged) judgements_[block] = judge_(block);
    return judgements_[block];
  }

  template <typename IsMeant>
  void judge_those(const IsMeant& is_meant) {
    tbb::parallel_for(0u, grid_.height, [&](std::uint32_t y) {
      for (std::uint32_t x = 0; x < grid_.width; ++x) {
        if (is_meant(x, y)) (void)at(std::size_t{y} * grid_.width + x);
      }
    });
  }

  // Five of every nine blocks in a square are judged first, wherever the square lies. Only where they leave it open
  // whether some block counts are the others judged.
  void judge_what_may_count() {
    judge_those([](std::uint32_t x, std::uint32_t y) { return (3 * (y % 3) + x % 3) % 2 == 0; });
    const std::vector<std::uint8_t> may_count = counted_around(grid_, kNeighboursAgreeing, [&](std::size_t block) {
      return judgements_[block] == Judgement::unjudged || judgements_[block] == Judgement::contradicted;
    });
    std::vector<std::uint8_t> wanted(grid_.size(), 0);
    for_each_block(grid_, [&](std::uint32_t x, std::uint32_t y, std::size_t block) {
      if (may_count[block]) around(grid_, x, y, [&](std::size_t neighbour) { wanted[neighbour] = 1; });
    });
    judge_those([&](std::uint32_t x, std::uint32_t y) { return wanted[std::size_t{y} * grid_.width + x] != 0; });
  }

  [[nodiscard]] bool is_square(std::uint32_t left, std::uint32_t top) const {
    for (std::uint32_t y = top; y < top + kThick; ++y) {
      for (std::uint32_t x = left; x < left + kThick; ++x) {
        if (!counts_[std::size_t{y} * grid_.width + x]) return false;
      }
    }
    return true;
  }

  // Returns 1 for the blocks that count and are joined to a square of them.
  [[nodiscard]] std::vector<std::uint8_t> with_square() const {
    std::vector<std::uint8_t> result(grid_.size(), 0);
    std::vector<std::size_t> open;
    for_each_block(grid_, [&](std::uint32_t x, std::uint32_t y, std::size_t block) {
      if (x + kThick > grid_.width || y + kThick > grid_.height || !is_square(x, y)) return;
      open.push_back(block);
      result[block] = 1;
    });
    while (!open.empty()) {
      const std::size_t block = open.back();
      open.pop_back();
      around(grid_, static_cast<std::uint32_t>(block % grid_.width), static_cast<std::uint32_t>(block / grid_.width),
             [&](std::size_t neighbour) {
               if (!counts_[neighbour] || result[neighbour]) return;
               result[neighbour] = 1;
               open.push_back(neighbour);
             });
    }
    return result;
  }

  void grow_over_doubtful() {
    const std::vector<std::uint8_t> reached =
        counted_around(grid_, 1, [&](std::size_t block) { return occluder_[block] != 0; });
    for (std::size_t block = 0; block < grid_.size(); ++block) {
      if (!reached[block] || occluder_[block]) continue;
      occluder_[block] = at(block) == Judgement::contradicted || at(block) == Judgement::doubtful;
    }
  }

  [[nodiscard]] bool is_same(std::size_t a, std::size_t b) const {
    const glm::dvec3 off = glm::abs(grid_.color[a] - grid_.color[b]);
    return std::max({off.r, off.g, off.b}) < kSameColor;
  }

  // Returns the blocks of the segment of `first`, which `is_taken` has from then on.
  std::vector<std::size_t> segment_of(std::size_t first, std::vector<std::uint8_t>& is_taken) const {
    std::vector<std::size_t> segment{first};
    is_taken[first] = 1;
    for (std::size_t next = 0; next < segment.size(); ++next) {
      const std::size_t block = segment[next], x = block % grid_.width, y = block / grid_.width;
      const auto visit = [&](std::size_t neighbour) {
        if (is_taken[neighbour] || !is_same(block, neighbour)) return;
        is_taken[neighbour] = 1;
        segment.push_back(neighbour);
      };
      if (x > 0) visit(block - 1);
      if (x + 1 < grid_.width) visit(block + 1);
      if (y > 0) visit(block - grid_.width);
      if (y + 1 < grid_.height) visit(block + grid_.width);
    }
    return segment;
  }

  void complete_segments() {
    std::vector<std::uint8_t> is_taken(grid_.size(), 0);
    const std::vector<std::uint8_t> counted = occluder_;
    for (std::size_t first = 0; first < grid_.size(); ++first) {
      if (!counted[first] || is_taken[first]) continue;
      std::vector<std::size_t> unknown;
      std::size_t for_it = 0, against = 0;
      for (const std::size_t block : segment_of(first, is_taken)) {
        if (counted[block]) {
          ++for_it;
        } else if (at(block) == Judgement::unknown) {
          unknown.push_back(block);
        } else {
          ++against;
        }
      }
      if (for_it < kVotes * against) continue;
      for (const std::size_t block : unknown) occluder_[block] = 1;
    }
  }

  const TrustGrid& grid_;
  const std::function<Judgement(std::size_t)>& judge_;
  std::vector<Judgement> judgements_;
  std::vector<std::uint8_t> counts_, occluder_;
};

}  // namespace

std::vector<std::uint8_t> contradicted_regions(const TrustGrid& grid,
                                               const std::function<Judgement(std::size_t)>& judge, TrustExtent extent) {
  return Regions(grid, judge).found(extent);
}

}  // namespace lumatlas
