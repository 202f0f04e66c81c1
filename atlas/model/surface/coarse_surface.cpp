// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/surface/coarse_surface.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <vector>

#include "mesh/base/median.h"
#include "mesh/repair/joined_faces.h"
#include "mesh/repair/simplification.h"
#include "mesh/used_vertices.h"

namespace lumatlas {

namespace {

constexpr double kMostError = 0.02;  // share of the mesh's extent

// The mesh in about `faces` faces; parts that do not hang together may be joined.
CoarseSurface clustered(const Mesh& mesh, std::size_t faces, double extent, double most_error) {
  std::vector<std::uint32_t> all;
  all.reserve(3 * mesh.faces.size());
  for (const glm::uvec3& face : mesh.faces) all.insert(all.end(), {face.x, face.y, face.z});
  std::vector<std::uint32_t> corners(all.size());
  float error = 0;  // share of the mesh's extent
  corners.resize(meshopt_simplifySloppy(corners.data(), all.data(), all.size(), &mesh.positions[0].x,
                                        mesh.positions.size(), sizeof(glm::vec3), 3 * faces,
                                        static_cast<float>(most_error), &error));
  UsedVertices used(mesh.positions.size());
  CoarseSurface result;
  result.error = error * extent;
  for (std::uint32_t& corner : corners) {
    const std::uint32_t vertex = corner;
    corner = used.number_of(vertex, [&] {
      result.mesh.positions.push_back(mesh.positions[vertex]);
      result.mesh.colors.push_back(mesh.colors[vertex]);
    });
  }
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    result.mesh.faces.emplace_back(corners[i], corners[i + 1], corners[i + 2]);
  }
  return result;
}

}  // namespace

double geometric_error(const CoarseSurface& coarse) {
  constexpr double kPixels = 16;
  std::vector<float> lengths;
  lengths.reserve(3 * coarse.mesh.faces.size());
  for (const glm::uvec3& face : coarse.mesh.faces) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::vec3 &from = coarse.mesh.positions[face[corner]], &to = coarse.mesh.positions[face[(corner + 1) % 3]];
      lengths.push_back(glm::distance(from, to));
    }
  }
  if (lengths.empty()) return 0;
  return std::max(coarse.error, kPixels * static_cast<double>(upper_median(lengths)));
}

bool needs_coarse_surface(std::size_t faces, std::size_t coarse_faces) {
  return coarse_faces > 0 && faces > coarse_faces && faces - coarse_faces > coarse_faces;
}

CoarseSurface coarse_surface(const Mesh& mesh, std::size_t faces, CoarseSource source) {
  // Where vertices are split, as at the borders of cells, the surface has no border.
  const Mesh colored{mesh.positions, mesh.colors, joined_faces(mesh)};
  const Bounds box = bounds(mesh);
  const double extent = std::max({box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z});
  SimplifiedMesh few = simplified(colored, {kMostError * extent, faces});
  // A surface in many small pieces, or with many borders, has edges that may not go.
  if (few.mesh.faces.size() > 2 * faces) {
    return clustered(colored, faces, extent, source == CoarseSource::surface ? kMostError : 1);
  }
  return {std::move(few.mesh), few.distance};
}

}  // namespace lumatlas
