// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: which two faces meet at each edge, in time that does not depend on how many meet at a vertex.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace lumatlas {

inline constexpr std::uint32_t kNoHalfedge = std::numeric_limits<std::uint32_t>::max();

// The halfedges of a triangle list are numbered 3 f + c: from corner c of face f to its next corner. Returns for each
// the one in the other direction on the neighbouring face, or kNoHalfedge where the surface ends. It ends too at an
// edge that is not manifold, which more than two faces have, or two that turn against each other.
//
// `faces` is a range of triangles t with vertices t[0], t[1], t[2] below `vertices`. It must have at most 7e8 faces.
// Each face is looked up a fixed number of times, whatever the valence of its vertices.
template <typename Faces>
[[nodiscard]] std::vector<std::uint32_t> opposite_halfedges(std::size_t vertices, const Faces& faces) {
  // Every edge is filed under the lower of its vertices, as a number that sorts by the upper one and then by halfedge;
  // the last bit tells in which direction the halfedge goes.
  const auto use = [](std::uint32_t from, std::uint32_t to, std::size_t halfedge) {
    return std::uint64_t{std::max(from, to)} << 32 | halfedge << 1 | (from < to ? 1u : 0u);
  };
  const auto upper = [](std::uint64_t entry) { return static_cast<std::uint32_t>(entry >> 32); };
  const auto halfedge = [](std::uint64_t entry) { return static_cast<std::uint32_t>(entry) >> 1; };
  std::vector<std::uint32_t> end(vertices + 1, 0);
  for (std::size_t face = 0; face < faces.size(); ++face) {
    const auto& corners = faces[face];
    for (int c = 0; c < 3; ++c) ++end[std::min(corners[c], corners[(c + 1) % 3]) + 1];
  }
  for (std::size_t vertex = 1; vertex <= vertices; ++vertex) end[vertex] += end[vertex - 1];
  // Filing moves each begin to the end of its list, so that end[v] is where v's list ends and that of v + 1 begins.
  std::vector<std::uint64_t> uses(3 * faces.size());
  for (std::size_t face = 0; face < faces.size(); ++face) {
    const auto& corners = faces[face];
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t from = corners[c], to = corners[(c + 1) % 3];
      uses[end[std::min(from, to)]++] = use(from, to, 3 * face + static_cast<std::size_t>(c));
    }
  }
  std::vector<std::uint32_t> opposite(uses.size(), kNoHalfedge);
  const auto pair_if_manifold = [&](const std::uint64_t* first, std::ptrdiff_t count) {
    if (count != 2 || (first[0] & 1) == (first[1] & 1)) return;
    const std::uint32_t a = halfedge(first[0]), b = halfedge(first[1]);
    if (a / 3 == b / 3) return;
    opposite[a] = b;
    opposite[b] = a;
  };
  const auto pair_uses = [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t vertex = range.begin(); vertex < range.end(); ++vertex) {
      std::uint64_t* first = uses.data() + (vertex == 0 ? 0 : end[vertex - 1]);
      std::uint64_t* const stop = uses.data() + end[vertex];
      std::sort(first, stop);
      while (first != stop) {
        const std::uint64_t* next = first + 1;
        while (next != stop && upper(*next) == upper(*first)) ++next;
        pair_if_manifold(first, next - first);
        first += next - first;
      }
    }
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices, 4096), pair_uses);
  return opposite;
}

}  // namespace lumatlas
