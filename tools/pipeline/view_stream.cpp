// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/view_stream.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace lumatlas {

namespace {

// std::shuffle, and what it draws by, differ between standard libraries. The bias of % is below 2^-32 for any list that
// fits into memory.
void shuffle(std::vector<std::size_t>& values, std::mt19937_64& random) {
  for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[random() % i]);
}

}  // namespace

std::vector<std::size_t> in_order(std::vector<std::size_t> ranks, StreamOrder order, std::mt19937_64& random) {
  if (order == StreamOrder::reversed) std::reverse(ranks.begin(), ranks.end());
  if (order == StreamOrder::shuffled) shuffle(ranks, random);
  return ranks;
}

std::vector<std::size_t> evenly_spaced(std::size_t count, std::size_t of) {
  count = std::min(count, of);
  std::vector<std::size_t> numbers(count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = (2 * i + 1) * of / (2 * count);
  return numbers;
}

std::vector<std::size_t> random_choice(std::size_t count, std::size_t of, std::mt19937_64& random) {
  std::vector<std::size_t> numbers(of);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  shuffle(numbers, random);
  numbers.resize(std::min(count, of));
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

}  // namespace lumatlas
