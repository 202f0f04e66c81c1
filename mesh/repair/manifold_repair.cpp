// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/manifold_repair.h"

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "mesh/repair/orientation.h"

namespace lumatlas {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

// One of a face's edges, as its ends are numbered.
struct EdgeUse {
  std::uint32_t low, high;
  std::uint32_t face;
  bool ascends;  // the face runs from `low` to `high`

  bool operator<(const EdgeUse& other) const {
    return std::tie(low, high, face) < std::tie(other.low, other.high, other.face);
  }
};

bool same_edge(const EdgeUse& a, const EdgeUse& b) {
  return a.low == b.low && a.high == b.high;
}

// Calls the function with the uses of each edge, first and past the last. `uses` is sorted.
template <typename Function>
void for_each_edge(const std::vector<EdgeUse>& uses, const Function& function) {
  for (auto first = uses.begin(); first != uses.end();) {
    const auto last = std::find_if(first, uses.end(), [&](const EdgeUse& use) { return !same_edge(*first, use); });
    function(first, last);
    first = last;
  }
}

// Appends the edges of a face that end at the vertex.
void append_uses_at(std::uint32_t vertex, const Triangle& face, std::uint32_t index, std::vector<EdgeUse>& uses) {
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::uint32_t from = face[corner], to = face[(corner + 1) % 3];
    if (from == vertex || to == vertex) uses.push_back({std::min(from, to), std::max(from, to), index, from < to});
  }
}

// Returns how many edges between suspects have three faces or more; all others have at most two.
std::uint64_t edges_with_three_faces(const TriangleList& faces, const VertexFaces& around,
                                     const std::vector<std::uint32_t>& suspects) {
  std::uint64_t count = 0;
  std::vector<EdgeUse> uses;
  for (const std::uint32_t vertex : suspects) {
    uses.clear();
    for (const std::uint32_t face : around[vertex]) append_uses_at(vertex, faces[face], face, uses);
    // An edge is looked at from its lower end.
    std::erase_if(uses, [&](const EdgeUse& use) {
      return use.low != vertex || !std::binary_search(suspects.begin(), suspects.end(), use.high);
    });
    std::sort(uses.begin(), uses.end());
    for_each_edge(uses, [&](auto first, auto last) { count += last - first > 2 ? 1 : 0; });
  }
  return count;
}

// The fans of faces around a vertex: for each of its faces, ascending, the index of the first face of its fan.
std::vector<std::size_t> fans_around(std::uint32_t vertex, const TriangleList& faces, const VertexFaces& around) {
  const auto star = around[vertex];
  std::vector<EdgeUse> uses;
  for (std::size_t i = 0; i < star.size(); ++i) {
    append_uses_at(vertex, faces[star[i]], static_cast<std::uint32_t>(i), uses);
  }
  std::sort(uses.begin(), uses.end());
  std::vector<std::size_t> rank(star.size(), 0), parent(star.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  boost::disjoint_sets<std::size_t*, std::size_t*> sets(rank.data(), parent.data());
  for_each_edge(uses, [&](auto first, auto last) {
    if (last - first == 2 && first->ascends != first[1].ascends) sets.union_set(first->face, first[1].face);
  });
  std::vector<std::size_t> first_of(star.size(), star.size()), fans(star.size());
  for (std::size_t i = 0; i < star.size(); ++i) {
    std::size_t& first = first_of[sets.find_set(i)];
    first = std::min(first, i);
    fans[i] = first;
  }
  return fans;
}

// A face whose corner at a vertex becomes a copy of it.
struct MovedCorner {
  std::uint32_t face, vertex, copy;
};

}  // namespace

std::vector<std::uint32_t> duplicate_faces(const TriangleList& faces, const VertexFaces& around,
                                           const std::vector<std::uint32_t>& suspects) {
  // All faces with the same vertices are at the lowest of them, which is a suspect.
  std::vector<std::pair<Triangle, std::uint32_t>> at_vertex;
  std::vector<std::uint32_t> dropped;
  for (const std::uint32_t vertex : suspects) {
    at_vertex.clear();
    for (const std::uint32_t face : around[vertex]) {
      Triangle corners = faces[face];
      std::sort(corners.begin(), corners.end());
      if (corners[0] == vertex) at_vertex.emplace_back(corners, face);
    }
    std::sort(at_vertex.begin(), at_vertex.end());
    for (std::size_t i = 1; i < at_vertex.size(); ++i) {
      if (at_vertex[i].first == at_vertex[i - 1].first) dropped.push_back(at_vertex[i].second);
    }
  }
  std::sort(dropped.begin(), dropped.end());
  return dropped;
}

std::size_t drop_duplicate_faces(TriangleList& faces, const VertexFaces& around,
                                 const std::vector<std::uint32_t>& suspects) {
  const std::vector<std::uint32_t> dropped = duplicate_faces(faces, around, suspects);
  std::uint32_t index = 0;
  auto next = dropped.begin();
  std::erase_if(faces, [&](const Triangle&) {
    const bool drop = next != dropped.end() && *next == index;
    next += drop;
    ++index;
    return drop;
  });
  return dropped.size();
}

// All fans are found before any face is changed, because an edge is told by its ends.
SplitVertices split_vertices(std::size_t vertices, TriangleList& faces, const VertexFaces& around,
                             const std::vector<std::uint32_t>& suspects) {
  SplitVertices result;
  std::vector<MovedCorner> moved;
  for (const std::uint32_t vertex : suspects) {
    const std::vector<std::size_t> fans = fans_around(vertex, faces, around);
    std::map<std::size_t, std::uint32_t> copies;  // for the first face of each fan except the vertex's own, the copy
    for (std::size_t i = 0; i < fans.size(); ++i) {
      if (fans[i] == 0) continue;
      if (fans[i] == i) {
        copies[i] = static_cast<std::uint32_t>(vertices + result.copies.size());
        result.copies.push_back(vertex);
      }
      moved.push_back({around[vertex][i], vertex, copies[fans[i]]});
    }
    result.vertices += copies.empty() ? 0 : 1;
  }
  for (const MovedCorner& corner : moved) {
    std::replace(faces[corner.face].begin(), faces[corner.face].end(), corner.vertex, corner.copy);
  }
  return result;
}

OrientedFaces orient_and_split(std::size_t vertices, TriangleList& faces, const VertexFaces& around,
                               const std::vector<std::uint32_t>& suspects) {
  OrientedFaces result;
  result.non_manifold_edges = edges_with_three_faces(faces, around, suspects);
  const std::vector<std::uint32_t> turned = faces_to_turn(vertices, faces, suspects);
  for (const std::uint32_t face : turned) std::reverse(faces[face].begin(), faces[face].end());
  result.reversed_faces = turned.size();
  SplitVertices split = split_vertices(vertices, faces, around, suspects);
  result.split_vertices = split.vertices;
  result.copies = std::move(split.copies);
  return result;
}

}  // namespace lumatlas
