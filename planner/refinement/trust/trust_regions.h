// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to planner/: from judgements of single blocks to the regions of a photograph that get little trust.
//
// 1. A block counts if most of the 3x3 blocks around it are contradicted. Lone ones are errors of alignment.
// 2. Of blocks that count and touch each other, those are an occluder that somewhere have a square of kThick blocks a
//    side. Thinner ones are strips along edges that are out of their place, and stay as they are.
// 3. An occluder grows over blocks that are contradicted or doubtful, by kDoubtfulReach blocks: it has parts whose
//    colours are near those of the surface behind.
// 4. Blocks of about the same colour that touch each other are a segment. Where at least kVotes times as many of its
//    blocks are an occluder's as are trusted, its unknown blocks are the occluder's too: a person's coat is judged as a
//    whole, although few views show what is behind some of it. A segment of the background has trusted blocks, which
//    keep it.
// 5. What counts grows by one block, because its edges are blurred.
//
// With TrustExtent::blocks the second to fourth step are left out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "planner/refinement/trust/trust.h"
#include "planner/refinement/trust/trust_blocks.h"

namespace lumatlas {

inline constexpr std::uint32_t kThick = 5;  // blocks
inline constexpr int kDoubtfulReach = 3;    // blocks
inline constexpr double kSameColor = 0.05;  // largest difference of a channel, square roots of linear light
inline constexpr std::size_t kVotes = 4;    // occluder's blocks for each trusted one of a segment

// Returns 1 for each block that gets little trust, 0 for the others. `judge` is called at most once a block, by several
// threads at once, and only for those that it may depend on.
[[nodiscard]] std::vector<std::uint8_t> contradicted_regions(const TrustGrid& grid,
                                                             const std::function<Judgement(std::size_t)>& judge,
                                                             TrustExtent extent);

}  // namespace lumatlas
