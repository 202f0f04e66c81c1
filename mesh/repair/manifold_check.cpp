// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/manifold_check.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <utility>

namespace lumatlas {

namespace {

using Face = std::array<std::uint32_t, 3>;
// The edge of a face that lies opposite a vertex, from its start to its end in the face's direction.
using LinkEdge = std::pair<std::uint32_t, std::uint32_t>;

LinkEdge opposite_edge(const Face& face, std::uint32_t vertex) {
  if (face[0] == vertex) return {face[1], face[2]};
  if (face[1] == vertex) return {face[2], face[0]};
  return {face[0], face[1]};
}

bool starts_at(const LinkEdge& edge, std::uint32_t vertex) {
  return edge.first < vertex;
}

// The edge from which the walk along the link begins: one that no other leads to, or any if they form cycles.
// `ends` is sorted.
LinkEdge first_of_chain(const std::vector<LinkEdge>& link, const std::vector<std::uint32_t>& ends) {
  const auto leads_nowhere_back = [&](const LinkEdge& edge) {
    return !std::binary_search(ends.begin(), ends.end(), edge.first);
  };
  const auto found = std::find_if(link.begin(), link.end(), leads_nowhere_back);
  return found == link.end() ? link.front() : *found;
}

// `link` holds the edges opposite a vertex: one directed chain, or one directed cycle of three or more?
bool is_chain_or_cycle(std::vector<LinkEdge>& link, std::vector<std::uint32_t>& ends) {
  std::sort(link.begin(), link.end());
  ends.clear();
  for (const LinkEdge& edge : link) ends.push_back(edge.second);
  std::sort(ends.begin(), ends.end());
  const auto same_start = [](const LinkEdge& a, const LinkEdge& b) { return a.first == b.first; };
  if (std::adjacent_find(link.begin(), link.end(), same_start) != link.end()) return false;
  if (std::adjacent_find(ends.begin(), ends.end()) != ends.end()) return false;

  const LinkEdge first = first_of_chain(link, ends);
  LinkEdge edge = first;
  std::size_t walked = 1;
  while (edge.second != first.first) {
    const auto next = std::lower_bound(link.begin(), link.end(), edge.second, starts_at);
    if (next == link.end() || next->first != edge.second) return walked == link.size();
    edge = *next;
    ++walked;
  }
  return walked == link.size() && walked >= 3;  // two: the same three vertices twice, facing opposite ways
}

void add_without_one_fan(const tbb::blocked_range<std::uint32_t>& range, const std::vector<Face>& faces,
                         const VertexFaces& around, std::vector<std::uint32_t>& found) {
  std::vector<LinkEdge> link;
  std::vector<std::uint32_t> ends;
  for (std::uint32_t vertex = range.begin(); vertex < range.end(); ++vertex) {
    link.clear();
    for (const std::uint32_t face : around[vertex]) link.push_back(opposite_edge(faces[face], vertex));
    if (!link.empty() && !is_chain_or_cycle(link, ends)) found.push_back(vertex);
  }
}

}  // namespace

std::vector<std::uint32_t> vertices_without_one_fan(std::size_t vertices, const std::vector<Face>& faces,
                                                    const VertexFaces& around) {
  using Found = std::vector<std::uint32_t>;
  const tbb::blocked_range<std::uint32_t> all(0, static_cast<std::uint32_t>(vertices), 4096);
  return tbb::parallel_reduce(
      all, Found(),
      [&](const tbb::blocked_range<std::uint32_t>& range, Found found) {
        add_without_one_fan(range, faces, around, found);
        return found;
      },
      [](Found first, const Found& second) {
        first.insert(first.end(), second.begin(), second.end());
        return first;
      });
}

}  // namespace lumatlas
