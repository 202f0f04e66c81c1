// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/photographed_share.h"

#include <algorithm>
#include <glm/glm.hpp>
#include <vector>

#include "tools/picture/paths/kept_path.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kGlancePx = 48;  // longer side

bool is_photographed(const Snapshot& snapshot, CellId cell, const glm::dvec3& point, const glm::dvec3& from) {
  const double distance = glm::distance(point, from);
  const glm::dvec3 direction = (point - from) / distance;
  const auto views = snapshot.references.of_cell(cell);
  return std::any_of(views.begin(), views.end(), [&](ViewSlot slot) {
    const glm::dvec3 from_view = point - snapshot.views[slot]->camera.center();
    const double view_distance = glm::length(from_view);
    return view_distance < kPhotographedEnlargement * distance &&
           glm::dot(from_view, direction) > kPhotographedCosine * view_distance;
  });
}

}  // namespace

double photographed_share(const Snapshot& snapshot, const Visibility& visibility, const Camera& camera) {
  const Camera coarse = camera.shrunk_to(kGlancePx);
  const VisibilityBuffer seen = visibility.trace(coarse);
  const glm::dvec3 from = coarse.center();
  std::size_t photographed = 0;
  for (std::size_t pixel = 0; pixel < seen.face.size(); ++pixel) {
    if (seen.face[pixel] == FaceId::none) continue;
    const glm::dvec2 at(static_cast<double>(pixel % coarse.width) + 0.5,
                        static_cast<double>(pixel / coarse.width) + 0.5);
    const glm::dvec3 point = from + static_cast<double>(seen.depth[pixel]) * coarse.ray(at);
    if (is_photographed(snapshot, snapshot.surface->cells.cell_of_face[seen.face[pixel]], point, from)) ++photographed;
  }
  return static_cast<double>(photographed) / static_cast<double>(seen.face.size());
}

}  // namespace lumatlas
