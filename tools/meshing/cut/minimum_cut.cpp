// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/cut/minimum_cut.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

namespace lumatlas {
namespace {

using Node = std::uint32_t;
using Side = std::uint32_t;

constexpr Node kNotQueued = std::numeric_limits<Node>::max();
constexpr std::uint32_t kFar = std::numeric_limits<std::uint32_t>::max();

// The link of a node to its tree: the side to its parent, 0 to 3, or one of these.
constexpr std::uint8_t kRoot = 4;    // on the source or the sink itself
constexpr std::uint8_t kOrphan = 5;  // its edge to the parent has no capacity left
constexpr std::uint8_t kFree = 6;    // in neither tree

class Cutter {
 public:
  explicit Cutter(CutGraph graph)
      : opposite_(std::move(graph.opposite)),
        residual_(std::move(graph.capacity)),
        terminal_(std::move(graph.from_source)),
        parent_(terminal_.size(), kFree),
        of_sink_(terminal_.size(), 0),
        next_(terminal_.size(), kNotQueued),
        marked_(terminal_.size(), 0),
        distance_(terminal_.size(), 0) {
    for (std::size_t node = 0; node < terminal_.size(); ++node) {
      terminal_[node] -= graph.to_sink[node];  // flow that goes straight through
      if (terminal_[node] == 0) continue;
      parent_[node] = kRoot;
      of_sink_[node] = terminal_[node] < 0 ? 1 : 0;
      distance_[node] = 1;
      enqueue(static_cast<Node>(node));
    }
  }

  std::vector<bool> cut() {
    while (const std::optional<Node> node = first_active()) {
      while (parent_[*node] != kFree) {
        const std::optional<Side> meeting = grow(*node);
        if (!meeting) break;
        ++time_;
        augment(*meeting);
        adopt();
      }
    }
    std::vector<bool> result(parent_.size());
    for (std::size_t node = 0; node < result.size(); ++node)
      result[node] = parent_[node] != kFree && of_sink_[node] == 0;
    return result;
  }

 private:
  static Node node_of(Side side) { return side / 4; }
  [[nodiscard]] Node neighbor(Side side) const { return node_of(opposite_[side]); }
  [[nodiscard]] Side parent_side(Node node) const { return 4 * node + parent_[node]; }

  // The capacity that is left along the tree of `sink`: from the neighbour to the side's node in the source's tree, the
  // other way in the sink's.
  [[nodiscard]] Capacity towards(Side side, bool sink) const { return residual_[sink ? side : opposite_[side]]; }

  // Active nodes are a list, of which the last one names itself.
  void enqueue(Node node) {
    if (next_[node] != kNotQueued) return;
    next_[node] = node;
    (last_ == kNotQueued ? first_ : next_[last_]) = node;
    last_ = node;
  }
  std::optional<Node> first_active() {
    if (first_ == kNotQueued) return std::nullopt;
    const Node node = first_;
    first_ = next_[node] == node ? kNotQueued : next_[node];
    if (first_ == kNotQueued) last_ = kNotQueued;
    next_[node] = kNotQueued;
    return node;
  }

  // Adds the free neighbours of a node to its tree. Returns the side of a source's node that touches the sink's tree,
  // if there is one.
  std::optional<Side> grow(Node node) {
    const bool sink = of_sink_[node] != 0;
    for (Side side = 4 * node; side < 4 * node + 4; ++side) {
      const Side back = opposite_[side];
      if (residual_[sink ? back : side] == 0) continue;
      const Node other = node_of(back);
      if (parent_[other] == kFree) {
        of_sink_[other] = sink ? 1 : 0;
        hang(other, back, distance_[node] + 1);
        marked_[other] = marked_[node];
        enqueue(other);
      } else if ((of_sink_[other] != 0) != sink) {
        return sink ? back : side;
      } else if (marked_[other] <= marked_[node] && distance_[other] > distance_[node]) {
        hang(other, back, distance_[node] + 1);  // a shorter way to the root
        marked_[other] = marked_[node];
      }
    }
    return std::nullopt;
  }

  void hang(Node node, Side to_parent, std::uint32_t distance) {
    parent_[node] = static_cast<std::uint8_t>(to_parent % 4);
    distance_[node] = distance;
  }

  // The least capacity from a node to its root, at most `most`. Sets `node` to the root.
  Capacity least_to_root(Node& node, Capacity most) const {
    const bool sink = of_sink_[node] != 0;
    for (; parent_[node] != kRoot; node = neighbor(parent_side(node))) {
      most = std::min(most, towards(parent_side(node), sink));
    }
    return std::min(most, sink ? -terminal_[node] : terminal_[node]);
  }

  // Raises the flow of the path through the edge of `meeting` by all that the path lets through.
  void augment(Side meeting) {
    Node source = node_of(meeting), sink = neighbor(meeting);
    const Capacity least = least_to_root(sink, least_to_root(source, residual_[meeting]));
    residual_[meeting] -= least;
    residual_[opposite_[meeting]] += least;
    push(node_of(meeting), least);
    push(neighbor(meeting), least);
  }

  void push(Node node, Capacity flow) {
    const bool sink = of_sink_[node] != 0;
    while (parent_[node] != kRoot) {
      const Side up = parent_side(node), from = sink ? up : opposite_[up], to = opposite_[from];
      residual_[from] -= flow;
      residual_[to] += flow;
      const Node above = neighbor(up);
      if (residual_[from] == 0) orphan_first(node);
      node = above;
    }
    terminal_[node] += sink ? flow : -flow;
    if (terminal_[node] == 0) orphan_first(node);
  }

  void orphan_first(Node node) {
    parent_[node] = kOrphan;
    orphans_.push_front(node);
  }

  void adopt() {
    while (!orphans_.empty()) {
      const Node node = orphans_.front();
      orphans_.pop_front();
      if (!find_parent(node)) leave(node);
    }
  }

  bool find_parent(Node node) {
    const bool sink = of_sink_[node] != 0;
    std::uint32_t least = kFar;
    Side best = 0;
    for (Side side = 4 * node; side < 4 * node + 4; ++side) {
      const Node other = neighbor(side);
      if (towards(side, sink) == 0 || parent_[other] == kFree || (of_sink_[other] != 0) != sink) continue;
      const std::uint32_t distance = distance_to_root(other);
      if (distance >= least) continue;
      least = distance;
      best = side;
    }
    if (least == kFar) return false;
    hang(node, best, least + 1);
    marked_[node] = time_;
    return true;
  }

  // kFar if the way up ends at an orphan. Marks the way, so that the next one that joins it ends there.
  std::uint32_t distance_to_root(Node from) {
    std::uint32_t distance = 0;
    for (Node node = from;; node = neighbor(parent_side(node))) {
      if (marked_[node] == time_) {
        distance += distance_[node];
        break;
      }
      if (parent_[node] == kOrphan) return kFar;
      ++distance;
      if (parent_[node] == kRoot) break;
    }
    std::uint32_t left = distance;
    for (Node node = from; marked_[node] != time_; node = neighbor(parent_side(node))) {
      marked_[node] = time_;
      distance_[node] = left--;
      if (parent_[node] == kRoot) break;
    }
    return distance;
  }

  // A node without a parent is free, its children are orphans, and neighbours may take it back later.
  void leave(Node node) {
    const bool sink = of_sink_[node] != 0;
    parent_[node] = kFree;
    for (Side side = 4 * node; side < 4 * node + 4; ++side) {
      const Node other = neighbor(side);
      if (parent_[other] == kFree || (of_sink_[other] != 0) != sink) continue;
      if (towards(side, sink) > 0) enqueue(other);
      if (parent_[other] < kRoot && parent_side(other) == opposite_[side]) {
        parent_[other] = kOrphan;
        orphans_.push_back(other);
      }
    }
  }

  std::vector<Side> opposite_;
  std::vector<Capacity> residual_;
  std::vector<Capacity> terminal_;       // the rest from the source, or below 0 to the sink
  std::vector<std::uint8_t> parent_;     // see above
  std::vector<std::uint8_t> of_sink_;    // the tree, of nodes that are not free
  std::vector<Node> next_;               // the next active node
  std::vector<std::uint32_t> marked_;    // when distance_ was right, at the latest
  std::vector<std::uint32_t> distance_;  // edges to the root
  std::deque<Node> orphans_;
  Node first_ = kNotQueued, last_ = kNotQueued;
  std::uint32_t time_ = 0;
};

}  // namespace

std::vector<bool> source_side(CutGraph graph) {
  const std::size_t nodes = graph.from_source.size();
  const bool fits = graph.to_sink.size() == nodes && graph.opposite.size() == 4 * nodes &&
                    graph.capacity.size() == 4 * nodes && nodes < kNotQueued / 4;
  if (!fits) throw std::invalid_argument("source_side: the lists of the graph do not fit each other");
  return Cutter(std::move(graph)).cut();
}

}  // namespace lumatlas
