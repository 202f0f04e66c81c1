// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/orientation.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <numeric>
#include <tuple>
#include <utility>

namespace lumatlas {

namespace {

using OrientedTriangle = TriangleList::value_type;
using FaceRange = tbb::blocked_range<std::uint32_t>;

// Returns whether an entry is not kNoTriangle, whose numbers no vertex has.
bool is_face(const OrientedTriangle& entry) {
  return entry[0] != kNoTriangle[0];
}

FaceRange all_of(const TriangleList& faces) {
  return {0, static_cast<std::uint32_t>(faces.size()), 1 << 14};
}

// Lists the faces for which is_wanted() holds, ascending.
template <typename Wanted>
std::vector<std::uint32_t> faces_that(const TriangleList& faces, const Wanted& is_wanted) {
  using Found = std::vector<std::uint32_t>;
  return tbb::parallel_reduce(
      all_of(faces), Found(),
      [&](const FaceRange& range, Found found) {
        for (std::uint32_t face = range.begin(); face < range.end(); ++face) {
          if (is_face(faces[face]) && is_wanted(face)) found.push_back(face);
        }
        return found;
      },
      [](Found first, const Found& second) {
        first.insert(first.end(), second.begin(), second.end());
        return first;
      });
}

// Sets of numbers, told by the least of each. Several threads may find and join at once: the sets are the same then.
class ConcurrentSets {
 public:
  explicit ConcurrentSets(std::size_t count) : parent_(count) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1 << 14), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        parent_[i].store(static_cast<std::uint32_t>(i), std::memory_order_relaxed);
      }
    });
  }
  std::uint32_t find(std::uint32_t number) {
    for (;;) {
      const std::uint32_t parent = parent_[number].load(std::memory_order_relaxed);
      if (parent == number) return number;
      const std::uint32_t above = parent_[parent].load(std::memory_order_relaxed);
      // Another thread may have set an ancestor farther up: either is one.
      if (above != parent) parent_[number].store(above, std::memory_order_relaxed);
      number = parent;
    }
  }
  void join(std::uint32_t a, std::uint32_t b) {
    if (parent_[a].load(std::memory_order_relaxed) == parent_[b].load(std::memory_order_relaxed)) return;
    for (;;) {
      std::uint32_t low = find(a), high = find(b);
      if (low == high) return;
      if (low > high) std::swap(low, high);
      if (parent_[high].compare_exchange_strong(high, low, std::memory_order_relaxed)) return;
    }
  }

 private:
  std::vector<std::atomic<std::uint32_t>> parent_;  // no number's is larger than itself
};

// Two faces that have an edge for themselves.
struct FacePair {
  std::uint32_t a, b;
};

struct EdgesOfTwo {
  std::vector<FacePair> agreeing;  // that run along their edge in both directions
  std::vector<FacePair> against;   // that run in one direction
};

// One of a face's edges between suspects.
struct SuspectEdge {
  std::uint32_t low, high, face;
  bool ascends;  // the face runs from `low` to `high`
  bool operator<(const SuspectEdge& other) const {
    return std::tie(low, high, face) < std::tie(other.low, other.high, other.face);
  }
};

class Orientation {
 public:
  Orientation(std::size_t vertices, const TriangleList& faces, const std::vector<std::uint32_t>& suspects)
      : faces_(faces), is_suspect_(vertices, 0) {
    for (const std::uint32_t vertex : suspects) is_suspect_[vertex] = 1;
  }

  std::vector<std::uint32_t> faces_to_turn() {
    const EdgesOfTwo edges = edges_between_suspects();
    if (edges.against.empty()) return {};
    find_patches(edges);
    measure_patches();
    std::vector<std::uint32_t> by_first_face(patches_.size());
    std::iota(by_first_face.begin(), by_first_face.end(), 0U);
    std::sort(by_first_face.begin(), by_first_face.end(),
              [&](std::uint32_t a, std::uint32_t b) { return patches_[a].first_face < patches_[b].first_face; });
    bool turns = false;
    for (const std::uint32_t patch : by_first_face) {
      if (!patches_[patch].seen) turns = choose_turns(patch) || turns;
    }
    if (!turns) return {};
    return faces_that(faces_, [&](std::uint32_t face) {
      const std::uint32_t patch = patch_of_member_[member(face)];
      return patch != kNoPatch && patches_[patch].turns_round;
    });
  }

 private:
  static constexpr std::uint32_t kNoPatch = ~0U;

  // Faces that are connected and turn the same way, if an edge of one has a face that turns against it.
  struct Patch {
    std::atomic<std::uint32_t> first_face = ~0U, faces = 0;
    std::vector<std::uint32_t> against;  // other patches, or itself
    bool seen = false, turns_round = false;
  };

  [[nodiscard]] int suspects_of(std::uint32_t face) const {
    const auto& [a, b, c] = faces_[face];
    return is_suspect_[a] + is_suspect_[b] + is_suspect_[c];
  }

  // All other edges have at most two faces, which turn the same way. Lists the faces of suspects alone besides.
  [[nodiscard]] EdgesOfTwo edges_between_suspects() {
    std::vector<SuspectEdge> uses;
    for (const std::uint32_t face : faces_that(faces_, [&](std::uint32_t f) { return suspects_of(f) >= 2; })) {
      if (suspects_of(face) == 3) alone_.push_back(face);
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t from = faces_[face][corner], to = faces_[face][(corner + 1) % 3];
        if ((is_suspect_[from] & is_suspect_[to]) == 0) continue;
        uses.push_back({std::min(from, to), std::max(from, to), face, from < to});
      }
    }
    tbb::parallel_sort(uses);
    EdgesOfTwo edges;
    for (auto first = uses.begin(); first != uses.end();) {
      const auto last = std::find_if(first, uses.end(), [&](const SuspectEdge& use) {
        return std::tie(use.low, use.high) != std::tie(first->low, first->high);
      });
      if (last - first == 2) {
        (first->ascends == first[1].ascends ? edges.against : edges.agreeing).push_back({first->face, first[1].face});
      }
      first = last;
    }
    return edges;
  }

  // Returns a member of the set that a face is in. A vertex that is no suspect holds all of its faces together, so that
  // vertices are joined instead of faces; faces of suspects alone stand for themselves.
  [[nodiscard]] std::uint32_t member(std::uint32_t face) const {
    for (const std::uint32_t vertex : faces_[face]) {
      if (is_suspect_[vertex] == 0) return vertex;
    }
    const auto found = std::lower_bound(alone_.begin(), alone_.end(), face);
    return static_cast<std::uint32_t>(is_suspect_.size() + static_cast<std::size_t>(found - alone_.begin()));
  }

  void join_corners(std::uint32_t face) {
    const std::uint32_t first = member(face);
    for (const std::uint32_t vertex : faces_[face]) {
      if (is_suspect_[vertex] == 0 && vertex != first) sets_.join(first, vertex);
    }
  }

  void find_patches(const EdgesOfTwo& edges) {
    sets_ = ConcurrentSets(is_suspect_.size() + alone_.size());
    tbb::parallel_for(all_of(faces_), [&](const FaceRange& range) {
      for (std::uint32_t face = range.begin(); face < range.end(); ++face) {
        if (is_face(faces_[face])) join_corners(face);
      }
    });
    for (const FacePair& pair : edges.agreeing) sets_.join(member(pair.a), member(pair.b));
    std::vector<std::uint32_t> patch_of_set(is_suspect_.size() + alone_.size(), kNoPatch);
    const auto number = [&](std::uint32_t face) {
      std::uint32_t& patch = patch_of_set[sets_.find(member(face))];
      if (patch == kNoPatch) {
        patch = static_cast<std::uint32_t>(patches_.size());
        patches_.emplace_back();
      }
      return patch;
    };
    for (const FacePair& pair : edges.against) {
      const std::uint32_t a = number(pair.a), b = number(pair.b);
      patches_[a].against.push_back(b);
      patches_[b].against.push_back(a);
    }
    patch_of_member_.resize(patch_of_set.size());
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(patch_of_set.size()), 1 << 14),
                      [&](const auto& range) {
                        for (std::uint32_t member = range.begin(); member < range.end(); ++member) {
                          patch_of_member_[member] = patch_of_set[sets_.find(member)];
                        }
                      });
  }

  // Counts the faces of each patch and finds the first. Faces of one patch in a row are counted together.
  void measure_patches() {
    tbb::parallel_for(all_of(faces_), [&](const FaceRange& range) {
      std::uint32_t patch = kNoPatch, first = 0, count = 0;
      const auto add = [&] {
        if (patch == kNoPatch) return;
        patches_[patch].faces += count;
        std::uint32_t known = patches_[patch].first_face;
        while (first < known && !patches_[patch].first_face.compare_exchange_weak(known, first)) {
        }
      };
      for (std::uint32_t face = range.begin(); face < range.end(); ++face) {
        if (!is_face(faces_[face])) continue;
        const std::uint32_t of_face = patch_of_member_[member(face)];
        if (of_face != patch) {
          add();
          patch = of_face;
          first = face;
          count = 0;
        }
        ++count;
      }
      add();
    });
  }

  // Turns patches round along a walk over those connected with `first`, which has not been seen; then all of them the
  // other way if more faces were turned than not. Returns whether any is turned round.
  bool choose_turns(std::uint32_t first) {
    std::vector<std::uint32_t> component{first};
    patches_[first].seen = true;
    std::uint64_t kept = 0, turned = 0;
    for (std::size_t next = 0; next < component.size(); ++next) {
      const Patch& patch = patches_[component[next]];
      (patch.turns_round ? turned : kept) += patch.faces;
      for (const std::uint32_t number : patch.against) {
        Patch& other = patches_[number];
        if (std::exchange(other.seen, true)) continue;
        other.turns_round = !patch.turns_round;
        component.push_back(number);
      }
    }
    if (turned <= kept) return turned > 0;
    for (const std::uint32_t number : component) patches_[number].turns_round = !patches_[number].turns_round;
    return kept > 0;
  }

  const TriangleList& faces_;
  std::vector<std::uint8_t> is_suspect_;        // by vertex
  std::vector<std::uint32_t> alone_;            // faces of suspects alone, ascending
  ConcurrentSets sets_{0};                      // of vertices, and of faces that are alone
  std::vector<std::uint32_t> patch_of_member_;  // of the sets
  std::deque<Patch> patches_;
};

}  // namespace

std::vector<std::uint32_t> faces_to_turn(std::size_t vertices, const TriangleList& faces,
                                         const std::vector<std::uint32_t>& suspects) {
  return suspects.empty() ? std::vector<std::uint32_t>() : Orientation(vertices, faces, suspects).faces_to_turn();
}

}  // namespace lumatlas
