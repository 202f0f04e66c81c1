// SPDX-License-Identifier: GPL-3.0-or-later
// Panels across the z axis, and photographs of them whose depths and colours are known.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"
#include "tools/meshing/measured_views.h"

namespace lumatlas {

// Adds a grid of squares of side 0.05 in a plane across the z axis, and returns the numbers of its faces.
struct FaceRange {
  std::size_t first = 0, end = 0;
};
inline FaceRange add_panel(double left, double right, double top, double bottom, double depth, Mesh& mesh) {
  const FaceRange before{mesh.faces.size(), 0};
  const auto columns = static_cast<std::uint32_t>(std::lround((right - left) / 0.05));
  const auto rows = static_cast<std::uint32_t>(std::lround((bottom - top) / 0.05));
  const auto start = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t y = 0; y <= rows; ++y) {
    for (std::uint32_t x = 0; x <= columns; ++x) mesh.positions.emplace_back(left + 0.05 * x, top + 0.05 * y, depth);
  }
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t a = start + y * (columns + 1) + x, b = a + columns + 1;
      mesh.faces.emplace_back(a, b, a + 1);
      mesh.faces.emplace_back(a + 1, b, b + 1);
    }
  }
  return {before.first, mesh.faces.size()};
}

// A photograph that shows the colours of what it sees, and has the depths of what was measured. Three others confirm
// them.
inline MeasuredView measured_view(const Camera& camera, const VisibilityBuffer& measured, const VisibilityBuffer& seen,
                                  const std::function<glm::vec3(const glm::dvec3&)>& color) {
  MeasuredView view;
  view.measured.camera = camera;
  for (std::size_t pixel = 0; pixel < seen.face.size(); ++pixel) {
    const bool is_known = seen.face[pixel] != FaceId::none;
    const float depth = is_known ? measured.depth[pixel] : 0;
    view.measured.depth.push_back(depth);
    view.measured.deviation.push_back(0.002F * depth);
    view.measured.agreeing.push_back(depth > 0 ? 7 : 0);
    view.color.push_back(is_known ? color(view.point_at(pixel, seen.depth[pixel])) : glm::vec3(0));
    view.valid.push_back(1);
  }
  return view;
}

// The share of some faces that are in an ascending list.
inline double share_in(const std::vector<std::uint32_t>& faces, const FaceRange& of) {
  const auto first = std::lower_bound(faces.begin(), faces.end(), of.first);
  const auto last = std::lower_bound(faces.begin(), faces.end(), of.end);
  return static_cast<double>(last - first) / static_cast<double>(of.end - of.first);
}

}  // namespace lumatlas
