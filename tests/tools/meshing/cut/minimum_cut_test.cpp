// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/cut/minimum_cut.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>
#include <stdexcept>

namespace lumatlas {
namespace {

// Sides are joined in pairs by chance, and capacities are small, so that there are ties and zeros.
CutGraph graph_by_chance(std::size_t nodes, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::uint32_t> sides(4 * nodes);
  std::iota(sides.begin(), sides.end(), 0U);
  std::shuffle(sides.begin(), sides.end(), random);
  CutGraph graph{std::vector<std::uint32_t>(4 * nodes), {}, {}, {}};
  for (std::size_t i = 0; i < sides.size(); i += 2) {
    graph.opposite[sides[i]] = sides[i + 1];
    graph.opposite[sides[i + 1]] = sides[i];
  }
  std::uniform_int_distribution<int> capacity(0, 6), terminal(0, 12);
  for (std::size_t i = 0; i < 4 * nodes; ++i) graph.capacity.push_back(capacity(random));
  for (std::size_t i = 0; i < nodes; ++i) {
    graph.from_source.push_back(std::max(0, terminal(random) - 6));
    graph.to_sink.push_back(std::max(0, terminal(random) - 6));
  }
  return graph;
}

Capacity cost_of(const CutGraph& graph, std::uint32_t of_source) {
  Capacity cost = 0;
  const auto is_in = [&](std::size_t node) { return (of_source >> node & 1U) != 0; };
  for (std::size_t node = 0; node < graph.to_sink.size(); ++node) {
    cost += is_in(node) ? graph.to_sink[node] : graph.from_source[node];
    for (std::size_t side = 4 * node; side < 4 * node + 4; ++side) {
      if (is_in(node) && !is_in(graph.opposite[side] / 4)) cost += graph.capacity[side];
    }
  }
  return cost;
}

TEST_CASE("the cut is the cheapest of all, and of these the one with the fewest nodes of the source") {
  constexpr std::size_t kNodes = 10;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    const CutGraph graph = graph_by_chance(kNodes, seed);
    std::uint32_t best = 0;
    Capacity least = cost_of(graph, 0);
    for (std::uint32_t nodes = 1; nodes < 1U << kNodes; ++nodes) {
      const Capacity cost = cost_of(graph, nodes);
      if (cost > least || (cost == least && __builtin_popcount(nodes) >= __builtin_popcount(best))) continue;
      least = cost;
      best = nodes;
    }
    const std::vector<bool> found = source_side(graph);
    for (std::size_t node = 0; node < kNodes; ++node) CHECK(found[node] == ((best >> node & 1U) != 0));
  }
}

TEST_CASE("no flow passes where nothing leaves the source, and a graph without nodes has no side") {
  CutGraph graph = graph_by_chance(6, 1);
  std::fill(graph.from_source.begin(), graph.from_source.end(), 0);
  CHECK(source_side(graph) == std::vector<bool>(6, false));
  CHECK(source_side({}).empty());
  graph.capacity.pop_back();
  CHECK_THROWS_AS(source_side(graph), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
