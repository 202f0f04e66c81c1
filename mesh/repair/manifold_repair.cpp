// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/manifold_repair.h"

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

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

// Two faces that have an edge for themselves.
struct Neighbours {
  std::uint32_t a, b;
};

// The edges between suspects. All others have at most two faces, which turn the same way.
struct SuspectEdges {
  std::uint64_t with_three_faces = 0;
  std::vector<Neighbours> agreeing;  // that run along their edge in both directions
  std::vector<Neighbours> against;   // that run in one direction
};

SuspectEdges suspect_edges(const TriangleList& faces, const VertexFaces& around,
                           const std::vector<std::uint32_t>& suspects) {
  SuspectEdges result;
  std::vector<EdgeUse> uses;
  for (const std::uint32_t vertex : suspects) {
    uses.clear();
    for (const std::uint32_t face : around[vertex]) append_uses_at(vertex, faces[face], face, uses);
    // An edge is looked at from its lower end.
    std::erase_if(uses, [&](const EdgeUse& use) {
      return use.low != vertex || !std::binary_search(suspects.begin(), suspects.end(), use.high);
    });
    std::sort(uses.begin(), uses.end());
    for_each_edge(uses, [&](auto first, auto last) {
      if (last - first > 2) ++result.with_three_faces;
      if (last - first != 2) return;
      (first->ascends == first[1].ascends ? result.against : result.agreeing).push_back({first->face, first[1].face});
    });
  }
  return result;
}

// The connected parts of a triangle list in which all faces turn the same way. A vertex that is no suspect holds all of
// its faces together, so that vertices are joined instead of faces; faces of suspects alone stand for themselves.
class Patches {
 public:
  Patches(std::size_t vertices, const TriangleList& faces, const VertexFaces& around,
          const std::vector<std::uint32_t>& suspects)
      : vertices_(vertices), is_suspect_(vertices, false) {
    for (const std::uint32_t vertex : suspects) is_suspect_[vertex] = true;
    for (const std::uint32_t vertex : suspects) {
      for (const std::uint32_t face : around[vertex]) {
        const Triangle& corners = faces[face];
        if (std::all_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return is_suspect_[v]; })) {
          alone_.push_back(face);
        }
      }
    }
    std::sort(alone_.begin(), alone_.end());
    alone_.erase(std::unique(alone_.begin(), alone_.end()), alone_.end());
    rank_.assign(vertices + alone_.size(), 0);
    parent_.resize(rank_.size());
    std::iota(parent_.begin(), parent_.end(), 0u);
    for (const Triangle& face : faces) join_corners(face);
  }

  void join(const TriangleList& faces, const Neighbours& pair) {
    sets().union_set(member(faces, pair.a), member(faces, pair.b));
  }

  // The same number for all faces of a patch.
  [[nodiscard]] std::uint32_t of(const TriangleList& faces, std::uint32_t face) {
    return sets().find_set(member(faces, face));
  }

 private:
  using Sets = boost::disjoint_sets<std::uint8_t*, std::uint32_t*>;
  Sets sets() { return {rank_.data(), parent_.data()}; }

  void join_corners(const Triangle& face) {
    std::uint32_t first = 0;
    bool found = false;
    for (const std::uint32_t vertex : face) {
      if (is_suspect_[vertex]) continue;
      if (found) sets().union_set(first, vertex);
      first = vertex;
      found = true;
    }
  }

  [[nodiscard]] std::uint32_t member(const TriangleList& faces, std::uint32_t face) const {
    for (const std::uint32_t vertex : faces[face]) {
      if (!is_suspect_[vertex]) return vertex;
    }
    const auto found = std::lower_bound(alone_.begin(), alone_.end(), face);
    return static_cast<std::uint32_t>(vertices_ + static_cast<std::size_t>(found - alone_.begin()));
  }

  std::size_t vertices_;
  std::vector<bool> is_suspect_;
  std::vector<std::uint32_t> alone_;  // ascending
  std::vector<std::uint8_t> rank_;
  std::vector<std::uint32_t> parent_;
};

// A patch that has an edge at which its faces turn against those of another, or against its own.
struct TurnedPatch {
  std::uint32_t first_face = 0;
  std::uint64_t faces = 0;
  std::vector<std::uint32_t> against;  // the numbers of the other patches
  bool seen = false, turns_round = false;
};

// Turns patches round along a walk over those connected with `first`, which has not been seen; then all of them the
// other way if more faces were turned than not.
void choose_turns(std::map<std::uint32_t, TurnedPatch>& patches, std::uint32_t first) {
  std::vector<std::uint32_t> component{first};
  patches[first].seen = true;
  std::uint64_t kept = 0, turned = 0;
  for (std::size_t next = 0; next < component.size(); ++next) {
    const TurnedPatch& patch = patches[component[next]];
    (patch.turns_round ? turned : kept) += patch.faces;
    for (const std::uint32_t number : patch.against) {
      TurnedPatch& other = patches[number];
      if (std::exchange(other.seen, true)) continue;
      other.turns_round = !patch.turns_round;
      component.push_back(number);
    }
  }
  if (turned <= kept) return;
  for (const std::uint32_t number : component) patches[number].turns_round = !patches[number].turns_round;
}

// Returns how many faces it has turned round.
std::uint64_t orient(std::size_t vertices, TriangleList& faces, const VertexFaces& around,
                     const std::vector<std::uint32_t>& suspects, const SuspectEdges& edges) {
  if (edges.against.empty()) return 0;
  Patches patches(vertices, faces, around, suspects);
  for (const Neighbours& pair : edges.agreeing) patches.join(faces, pair);
  std::map<std::uint32_t, TurnedPatch> turned;
  for (const Neighbours& pair : edges.against) {
    const std::uint32_t a = patches.of(faces, pair.a), b = patches.of(faces, pair.b);
    turned[a].against.push_back(b);
    turned[b].against.push_back(a);
  }
  std::vector<std::uint32_t> by_first_face;
  for (std::uint32_t face = 0; face < faces.size(); ++face) {
    const auto found = turned.find(patches.of(faces, face));
    if (found == turned.end()) continue;
    if (found->second.faces++ == 0) by_first_face.push_back(found->first);
  }
  for (const std::uint32_t number : by_first_face) {
    if (!turned[number].seen) choose_turns(turned, number);
  }
  std::uint64_t reversed = 0;
  for (std::uint32_t face = 0; face < faces.size(); ++face) {
    const auto found = turned.find(patches.of(faces, face));
    if (found == turned.end() || !found->second.turns_round) continue;
    std::reverse(faces[face].begin(), faces[face].end());
    ++reversed;
  }
  return reversed;
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

// All fans are found before any face is changed, because an edge is told by its ends.
void split(std::size_t vertices, TriangleList& faces, const VertexFaces& around,
           const std::vector<std::uint32_t>& suspects, OrientedFaces& result) {
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
    result.split_vertices += !copies.empty();
  }
  for (const MovedCorner& corner : moved) {
    std::replace(faces[corner.face].begin(), faces[corner.face].end(), corner.vertex, corner.copy);
  }
}

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

bool has_opposed_faces(const TriangleList& faces, const VertexFaces& around,
                       const std::vector<std::uint32_t>& suspects) {
  return !suspect_edges(faces, around, suspects).against.empty();
}

OrientedFaces orient_and_split(std::size_t vertices, TriangleList& faces, const VertexFaces& around,
                               const std::vector<std::uint32_t>& suspects) {
  OrientedFaces result;
  const SuspectEdges edges = suspect_edges(faces, around, suspects);
  result.non_manifold_edges = edges.with_three_faces;
  result.reversed_faces = orient(vertices, faces, around, suspects, edges);
  split(vertices, faces, around, suspects, result);
  return result;
}

}  // namespace lumatlas
