// SPDX-License-Identifier: GPL-3.0-or-later
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <compare>

#include "mesh/cells/cell_growth.h"
#include "mesh/face_corners.h"

namespace lumatlas {

namespace {

struct PlacedFace {
  FaceCorners corners;
  FaceId face;
  auto operator<=>(const PlacedFace&) const = default;  // NOLINT(modernize-use-nullptr): clang-tidy 14 misreads it
};

std::vector<PlacedFace> sorted_by_place(const Mesh& mesh) {
  std::vector<PlacedFace> placed(mesh.faces.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, placed.size(), 1024), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const FaceId face(static_cast<std::uint32_t>(i));
      placed[i] = {face_corners(mesh, face), face};
    }
  });
  tbb::parallel_sort(placed);
  return placed;
}

}  // namespace

std::vector<FaceId> match_faces(const Mesh& before, const Mesh& mesh) {
  check_faces(before);
  check_faces(mesh);
  const std::vector<PlacedFace> old_faces = sorted_by_place(before);
  std::vector<FaceId> matches(mesh.faces.size(), FaceId::none);
  auto old_face = old_faces.begin();
  for (const PlacedFace& placed : sorted_by_place(mesh)) {
    while (old_face != old_faces.end() && old_face->corners < placed.corners) ++old_face;
    if (old_face == old_faces.end()) break;
    if (old_face->corners == placed.corners) matches[placed.face] = (old_face++)->face;
  }
  return matches;
}

}  // namespace lumatlas
