// SPDX-License-Identifier: GPL-3.0-or-later
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <array>
#include <cmath>
#include <compare>

#include "mesh/cells/partitions.h"

namespace lumatlas {

namespace {

struct FaceInCube {
  std::array<double, 3> cube;  // its lowest corner, in cube edges; as double because it may exceed any integer
  std::uint32_t face;
  auto operator<=>(const FaceInCube&) const = default;  // NOLINT(modernize-use-nullptr): clang-tidy 14 misreads it
};

FaceInCube locate(const Mesh& mesh, std::uint32_t index, double size) {
  const glm::uvec3& face = mesh.faces[index];
  FaceInCube located{{}, index};
  for (int axis = 0; axis < 3; ++axis) {
    const double sum =
        static_cast<double>(mesh.positions[face.x][axis]) + mesh.positions[face.y][axis] + mesh.positions[face.z][axis];
    located.cube[axis] = std::floor(sum / 3 / size);
  }
  return located;
}

}  // namespace

std::vector<std::uint32_t> grid_labels(const Mesh& mesh, double size) {
  std::vector<FaceInCube> located(mesh.faces.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, located.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      located[i] = locate(mesh, static_cast<std::uint32_t>(i), size);
    }
  });
  tbb::parallel_sort(located);
  std::vector<std::uint32_t> labels(located.size());
  std::uint32_t cube = 0;
  for (std::size_t i = 0; i < located.size(); ++i) {
    if (i > 0 && located[i].cube != located[i - 1].cube) ++cube;
    labels[located[i].face] = cube;
  }
  return labels;
}

}  // namespace lumatlas
