// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/shapes/polyhedron.h"

#include <map>
#include <numbers>
#include <utility>

namespace lumatlas::synth {

using glm::dvec3;

namespace {

class FlatCut {
 public:
  FlatCut(const Polyhedron& base, std::uint32_t frequency) : base_(base), n_(frequency) { cut_.points = base.points; }

  Polyhedron run() {
    for (const glm::uvec3& face : base_.faces) cut_face(face);
    return std::move(cut_);
  }

 private:
  std::uint32_t edge_point(std::uint32_t a, std::uint32_t b, std::uint32_t step) {  // `step` of n_ from a to b
    if (step == 0) return a;
    if (step == n_) return b;
    if (a > b) return edge_point(b, a, n_ - step);
    const auto [entry, is_new] = edges_.try_emplace({a, b}, static_cast<std::uint32_t>(cut_.points.size()));
    for (std::uint32_t i = 1; is_new && i < n_; ++i) {
      cut_.points.push_back((base_.points[a] * static_cast<double>(n_ - i) + base_.points[b] * static_cast<double>(i)) /
                            static_cast<double>(n_));
    }
    return entry->second + step - 1;
  }

  // The point i steps from a towards b and j steps from a towards c.
  std::uint32_t point(const glm::uvec3& f, std::uint32_t i, std::uint32_t j) {
    if (j == 0) return edge_point(f.x, f.y, i);
    if (i == 0) return edge_point(f.x, f.z, j);
    if (i + j == n_) return edge_point(f.y, f.z, j);
    cut_.points.push_back((base_.points[f.x] * static_cast<double>(n_ - i - j) +
                           base_.points[f.y] * static_cast<double>(i) + base_.points[f.z] * static_cast<double>(j)) /
                          static_cast<double>(n_));
    return static_cast<std::uint32_t>(cut_.points.size() - 1);
  }

  void cut_face(const glm::uvec3& f) {
    std::vector<std::uint32_t> below;
    for (std::uint32_t i = 0; i <= n_; ++i) below.push_back(point(f, i, 0));
    for (std::uint32_t j = 1; j <= n_; ++j) {
      std::vector<std::uint32_t> row;
      for (std::uint32_t i = 0; i + j <= n_; ++i) row.push_back(point(f, i, j));
      for (std::uint32_t i = 0; i < row.size(); ++i) {
        cut_.faces.emplace_back(below[i], below[i + 1], row[i]);
        if (i + 1 < row.size()) cut_.faces.emplace_back(below[i + 1], row[i + 1], row[i]);
      }
      below = std::move(row);
    }
  }

  const Polyhedron& base_;
  std::uint32_t n_;
  Polyhedron cut_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edges_;  // first inner point, from the lower end
};

}  // namespace

Polyhedron icosahedron() {
  const double g = std::numbers::phi;
  Polyhedron p;
  p.points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
              {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  p.faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
             {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
             {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  return p;
}

Polyhedron cut_flat(const Polyhedron& base, std::uint32_t frequency) {
  return FlatCut(base, frequency).run();
}

}  // namespace lumatlas::synth
