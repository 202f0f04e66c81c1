// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/layout/chart_texels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <optional>

namespace lumatlas {

namespace {

using glm::dvec2;

double cross(const dvec2& a, const dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

// A face as it lies in a chart's rectangle.
struct FaceInChart {
  std::array<dvec2, 3> corners;
  double area2;  // twice its area, with a sign

  // Shares of the second and third corner at a point; none outside of the face.
  [[nodiscard]] std::optional<ChartTexel> inside(const dvec2& point) const {
    if (area2 == 0) return std::nullopt;
    const dvec2 ap = point - corners[0];
    const double b = cross(ap, corners[2] - corners[0]) / area2, c = cross(corners[1] - corners[0], ap) / area2;
    if (!(b >= 0 && c >= 0 && b + c <= 1)) return std::nullopt;
    return ChartTexel{0, static_cast<float>(b), static_cast<float>(c), 0};
  }

  // The same at the place of its edges that is nearest to a point.
  [[nodiscard]] ChartTexel nearest_on_edges(const dvec2& point) const {
    ChartTexel best;
    best.distance = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t next = (i + 1) % 3;
      const dvec2 edge = corners[next] - corners[i];
      const double length = glm::dot(edge, edge);
      const double t = length > 0 ? std::clamp(glm::dot(point - corners[i], edge) / length, 0.0, 1.0) : 0;
      const auto distance = static_cast<float>(glm::distance(point, corners[i] + t * edge));
      if (distance >= best.distance) continue;
      std::array<double, 3> shares{};
      shares[i] = 1 - t;
      shares[next] = t;
      best = {0, static_cast<float>(shares[1]), static_cast<float>(shares[2]), distance};
    }
    // A place on an edge is not in the face: at equal distance one that is inside another face wins.
    best.distance = std::max(best.distance, 1e-6f);
    return best;
  }
};

FaceInChart face_in_chart(const Mesh& mesh, FaceId face, const Chart& chart, const ChartPlace& place,
                          const TextureLayout& layout) {
  FaceInChart flat;
  for (int c = 0; c < 3; ++c) {
    flat.corners[static_cast<std::size_t>(c)] =
        layout.in_rectangle(chart, place, glm::dvec3(mesh.positions[mesh.faces[face][c]]));
  }
  flat.area2 = cross(flat.corners[1] - flat.corners[0], flat.corners[2] - flat.corners[0]);
  return flat;
}

// Calls use(texel, its middle) for all texels of the rectangle around the face, widened by `reach` texels on each side.
template <typename Use>
void for_each_texel(const FaceInChart& face, double reach, const ChartPlace& place, std::vector<ChartTexel>& texels,
                    const Use& use) {
  const dvec2 low = glm::min(glm::min(face.corners[0], face.corners[1]), face.corners[2]) - reach;
  const dvec2 high = glm::max(glm::max(face.corners[0], face.corners[1]), face.corners[2]) + reach;
  const auto first = [](double v) { return static_cast<std::uint32_t>(std::max(0.0, v)); };
  const auto last = [](double v, std::uint32_t size) {
    return std::min(size, static_cast<std::uint32_t>(std::max(0.0, v + 1)));
  };
  for (std::uint32_t y = first(low.y); y < last(high.y, place.height); ++y) {
    for (std::uint32_t x = first(low.x); x < last(high.x, place.width); ++x) {
      use(texels[std::size_t{y} * place.width + x], dvec2(x + 0.5, y + 0.5));
    }
  }
}

}  // namespace

std::vector<ChartTexel> chart_texels(const Mesh& mesh, const Chart& chart, const ChartPlace& place,
                                     const TextureLayout& layout) {
  std::vector<ChartTexel> texels(std::size_t{place.width} * place.height);
  for (const FaceId face : chart.faces) {
    const FaceInChart flat = face_in_chart(mesh, face, chart, place, layout);
    for_each_texel(flat, 0, place, texels, [&](ChartTexel& texel, const dvec2& middle) {
      if (texel.face != FaceId::none) return;
      const auto inside = flat.inside(middle);
      if (!inside) return;
      texel = *inside;
      texel.face = face;
    });
  }
  // Texels around the chart, which few faces are near: where all texels of a face are taken, nothing is computed.
  for (const FaceId face : chart.faces) {
    const FaceInChart flat = face_in_chart(mesh, face, chart, place, layout);
    for_each_texel(flat, ChartTexel::kReach, place, texels, [&](ChartTexel& texel, const dvec2& middle) {
      if (texel.face != FaceId::none && texel.distance == 0) return;
      ChartTexel found = flat.nearest_on_edges(middle);
      if (found.distance > ChartTexel::kReach) return;
      if (texel.face != FaceId::none && texel.distance <= found.distance) return;
      found.face = face;
      texel = found;
    });
  }
  return texels;
}

}  // namespace lumatlas
