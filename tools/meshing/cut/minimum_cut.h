// SPDX-License-Identifier: GPL-3.0-or-later
// The minimum cut of a graph whose nodes have four neighbours each, as tetrahedra have.
//
// Boykov and Kolmogorov, "An experimental comparison of min-cut/max-flow algorithms for energy minimization in vision",
// 2004. A tree from the source and one from the sink grow until they meet. Then the flow of the path between them is
// raised, and nodes that this cuts off the trees are joined to them again. Four neighbours need no lists of edges, so
// this takes a tenth of the memory of a graph of any form.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lumatlas {

// Whole numbers make the flow exact. The capacities of all edges of a node must add up to less than 2^62.
using Capacity = std::int64_t;

// Side `side`, 0 to 3, of node `node` is numbered 4 node + side.
struct CutGraph {
  std::vector<std::uint32_t> opposite;         // a side: the side of the neighbour that it touches
  std::vector<Capacity> capacity;              // a side: of the edge from its node to the neighbour, >= 0
  std::vector<Capacity> from_source, to_sink;  // a node, >= 0
};

// Returns for each node whether it is on the source's side of the minimum cut; of several, the one with the fewest such
// nodes. Takes 14 bytes a node beside the graph, which has 64. Throws std::invalid_argument if the lists of the graph
// do not fit each other.
[[nodiscard]] std::vector<bool> source_side(CutGraph graph);

}  // namespace lumatlas
