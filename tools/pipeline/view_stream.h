// SPDX-License-Identifier: GPL-3.0-or-later
// In which order a scene's views are offered, and choices of views that look at none of them.
#pragma once

#include <cstddef>
#include <random>
#include <vector>

namespace lumatlas {

enum class StreamOrder { given, reversed, shuffled };  // given: by name

// `random` is drawn from for StreamOrder::shuffled alone: the same numbers give the same order on every machine.
[[nodiscard]] std::vector<std::size_t> in_order(std::vector<std::size_t> ranks, StreamOrder order,
                                                std::mt19937_64& random);

// `count` of the numbers below `of`, at most all of them, ascending: each in the middle of its equal share of them.
[[nodiscard]] std::vector<std::size_t> evenly_spaced(std::size_t count, std::size_t of);

// The same, every choice as likely as any other.
[[nodiscard]] std::vector<std::size_t> random_choice(std::size_t count, std::size_t of, std::mt19937_64& random);

}  // namespace lumatlas
