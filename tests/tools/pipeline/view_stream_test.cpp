// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/view_stream.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

namespace lumatlas {
namespace {

using Numbers = std::vector<std::size_t>;

Numbers ranks_with_gaps() {
  Numbers ranks;
  for (std::size_t rank = 0; rank < 60; ++rank) {
    if (rank % 8 != 0) ranks.push_back(rank);
  }
  return ranks;
}

TEST_CASE("an order of the stream loses and invents no view, and depends on its seed alone") {
  const Numbers ranks = ranks_with_gaps();
  std::mt19937_64 random(1), same(1), other(2);
  CHECK(in_order(ranks, StreamOrder::given, random) == ranks);
  const Numbers reversed = in_order(ranks, StreamOrder::reversed, random);
  CHECK(reversed == Numbers(ranks.rbegin(), ranks.rend()));
  const Numbers shuffled = in_order(ranks, StreamOrder::shuffled, random);  // the first to draw from it
  CHECK(shuffled != ranks);
  CHECK(shuffled == in_order(ranks, StreamOrder::shuffled, same));
  CHECK(shuffled != in_order(ranks, StreamOrder::shuffled, other));
  Numbers sorted = shuffled;
  std::sort(sorted.begin(), sorted.end());
  CHECK(sorted == ranks);
}

TEST_CASE("shuffling puts every view everywhere about as often") {
  std::mt19937_64 random(3);
  constexpr std::size_t kOffered = 8, kRounds = 8000;
  std::vector<Numbers> times(kOffered, Numbers(kOffered, 0));
  Numbers ranks(kOffered);
  for (std::size_t i = 0; i < kOffered; ++i) ranks[i] = i;
  for (std::size_t round = 0; round < kRounds; ++round) {
    const Numbers shuffled = in_order(ranks, StreamOrder::shuffled, random);
    for (std::size_t place = 0; place < kOffered; ++place) ++times[shuffled[place]][place];
  }
  // Binomial, 1000 expected, standard deviation below 30: five of them.
  for (const Numbers& places : times) {
    for (const std::size_t count : places) CHECK((count > 850 && count < 1150));
  }
}

TEST_CASE("evenly spaced numbers are distinct, within range and leave gaps that differ by one at most") {
  CHECK(evenly_spaced(0, 10).empty());
  CHECK(evenly_spaced(3, 0).empty());
  CHECK(evenly_spaced(1, 10) == Numbers{5});
  CHECK(evenly_spaced(2, 8) == Numbers{2, 6});
  CHECK(evenly_spaced(4, 4) == Numbers{0, 1, 2, 3});
  CHECK(evenly_spaced(9, 4) == Numbers{0, 1, 2, 3});
  for (std::size_t of = 1; of < 60; ++of) {
    for (std::size_t count = 1; count <= of; ++count) {
      const Numbers numbers = evenly_spaced(count, of);
      REQUIRE(numbers.size() == count);
      REQUIRE(numbers.back() < of);
      for (std::size_t i = 1; i < count; ++i) {
        const std::size_t gap = numbers[i] - numbers[i - 1];
        REQUIRE((gap == of / count || gap == of / count + 1));
      }
    }
  }
}

TEST_CASE("a random choice has the size that was asked for, no number twice, and favours none") {
  std::mt19937_64 random(4);
  CHECK(random_choice(0, 5, random).empty());
  CHECK(random_choice(7, 3, random) == Numbers{0, 1, 2});
  Numbers times(20, 0);
  for (int round = 0; round < 4000; ++round) {
    const Numbers numbers = random_choice(5, 20, random);
    REQUIRE(numbers.size() == 5);
    REQUIRE(std::is_sorted(numbers.begin(), numbers.end()));
    REQUIRE(std::set<std::size_t>(numbers.begin(), numbers.end()).size() == 5);
    for (const std::size_t number : numbers) ++times[number];
  }
  // Binomial, 1000 expected, standard deviation below 28: five of them.
  for (const std::size_t count : times) CHECK((count > 860 && count < 1140));
}

}  // namespace
}  // namespace lumatlas
