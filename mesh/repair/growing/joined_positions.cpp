// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/growing/joined_positions.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <tuple>

#include "mesh/finite.h"
#include "mesh/repair/place_hash.h"

namespace lumatlas {

namespace {

// Some hashes, one bit for each 64th or so of what may be one of them.
class HashFilter {
 public:
  explicit HashFilter(std::size_t count)
      : shift_(64U - std::min(34U, static_cast<unsigned>(std::bit_width(count)) + 6U)),
        bits_((std::uint64_t{1} << (64U - shift_)) / 64) {}
  void add(std::uint64_t hash) { bits_[hash >> shift_ >> 6U] |= std::uint64_t{1} << (hash >> shift_ & 63U); }
  [[nodiscard]] bool may_have(std::uint64_t hash) const {
    return (bits_[hash >> shift_ >> 6U] >> (hash >> shift_ & 63U) & 1U) != 0;
  }

 private:
  unsigned shift_;
  std::vector<std::uint64_t> bits_;
};

struct HashedPosition {
  std::uint64_t hash;
  std::uint32_t position;
  bool is_new;
  bool operator<(const HashedPosition& other) const {
    return std::tie(hash, is_new, position) < std::tie(other.hash, other.is_new, other.position);
  }
};

// Returns the finite positions that may be where a new one is, those with the same hash in a row, new ones last.
std::vector<HashedPosition> suspected_positions(std::span<const glm::vec3> places, const PointOfPosition& points,
                                                std::span<const std::uint32_t> is_new) {
  HashFilter filter(is_new.size());
  for (const std::uint32_t position : is_new) filter.add(hash_of_place(places[position]));
  std::vector<HashedPosition> suspects;
  for (const std::uint32_t position : is_new) {
    if (is_finite(places[position])) suspects.push_back({hash_of_place(places[position]), position, true});
  }
  using Found = std::vector<HashedPosition>;
  const Found kept = tbb::parallel_reduce(
      tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(places.size()), 1 << 14), Found(),
      [&](const tbb::blocked_range<std::uint32_t>& range, Found found) {
        for (std::uint32_t position = range.begin(); position < range.end(); ++position) {
          if (points[position] == VertexId::none) continue;
          const std::uint64_t hash = hash_of_place(places[position]);
          if (filter.may_have(hash)) found.push_back({hash, position, false});
        }
        return found;
      },
      [](Found first, const Found& second) {
        first.insert(first.end(), second.begin(), second.end());
        return first;
      });
  suspects.insert(suspects.end(), kept.begin(), kept.end());
  tbb::parallel_sort(suspects);
  return suspects;
}

// Finds the points of new positions: one that is kept and at the same place, or the first of them.
void join_new(std::span<const glm::vec3> places, std::span<const std::uint32_t> is_new, PointOfPosition& points) {
  if (is_new.empty()) return;
  const std::vector<HashedPosition> suspects = suspected_positions(places, points, is_new);
  for (auto first = suspects.begin(); first != suspects.end();) {
    const auto end = std::find_if(first, suspects.end(), [&](const auto& other) { return other.hash != first->hash; });
    for (auto later = first; later != end; ++later) {
      if (!later->is_new) continue;
      const auto same = std::find_if(
          first, later, [&](const auto& other) { return places[other.position] == places[later->position]; });
      points[later->position] = same == later ? VertexId(later->position) : points[same->position];
    }
    first = end;
  }
}

}  // namespace

JoinedPositions joined_positions(std::span<const glm::vec3> places, std::span<const VertexId> previous_position,
                                 std::span<const VertexId> position_now, const PointOfPosition& before) {
  JoinedPositions joined{PointOfPosition(places.size(), VertexId::none), {}};
  std::vector<std::uint32_t> is_new;
  for (VertexId position{0}; position < places.size(); ++position) {
    const VertexId previous = previous_position.empty() ? VertexId::none : previous_position[position];
    if (previous == VertexId::none) {
      is_new.push_back(position);
      continue;
    }
    const VertexId point = before[previous];
    if (point == VertexId::none) continue;
    const VertexId now = position_now[point];
    joined.point[position] = now != VertexId::none ? now : joined.heirs.emplace(point, position).first->second;
  }
  join_new(places, is_new, joined.point);
  return joined;
}

}  // namespace lumatlas
