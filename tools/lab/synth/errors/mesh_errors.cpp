// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/errors/mesh_errors.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <queue>
#include <unordered_map>
#include <utility>
#include <vector>

#include "mesh/repair/decimation.h"
#include "mesh/repair/repair.h"
#include "tools/lab/synth/random.h"

namespace lumatlas::synth {
namespace {

using glm::dvec3;

enum MeshUse : std::uint64_t { kMeshNoise = 0x6d657368, kHoles };  // uses of random numbers

// Twice the area, along the normal.
dvec3 area_vector(const Mesh& mesh, const glm::uvec3& f) {
  const dvec3 a(mesh.positions[f.x]);
  return glm::cross(dvec3(mesh.positions[f.y]) - a, dvec3(mesh.positions[f.z]) - a);
}

dvec3 centroid(const Mesh& mesh, const glm::uvec3& f) {
  return (dvec3(mesh.positions[f.x]) + dvec3(mesh.positions[f.y]) + dvec3(mesh.positions[f.z])) / 3.0;
}

// Faces that share an edge with a face, three at most; none beyond a boundary.
std::vector<std::vector<std::uint32_t>> neighbours_of_faces(const Mesh& mesh) {
  std::vector<std::vector<std::uint32_t>> neighbours(mesh.faces.size());
  std::unordered_map<std::uint64_t, std::uint32_t> open;  // edges that one face was found at so far
  for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      const auto [low, high] = std::minmax({mesh.faces[face][corner], mesh.faces[face][(corner + 1) % 3]});
      const auto [entry, is_new] = open.try_emplace((std::uint64_t{low} << 32U) | high, face);
      if (is_new) continue;
      neighbours[face].push_back(entry->second);
      neighbours[entry->second].push_back(face);
      open.erase(entry);
    }
  }
  return neighbours;
}

// Cuts patches out of a mesh until as much of its area is gone as was asked for.
class HoleCutter {
 public:
  explicit HoleCutter(const Mesh& mesh)
      : mesh_(mesh), neighbours_(neighbours_of_faces(mesh)), gone_(mesh.faces.size(), 0) {
    for (const glm::uvec3& face : mesh.faces) area_below_.push_back(area_below_.back() + area(face));
    const Bounds box = bounds(mesh);
    diagonal_ = glm::distance(box.min, box.max);
  }

  std::vector<char> cut(double share, Random random) {
    left_ = share * area_below_.back();
    while (left_ > 0) {
      const std::uint32_t first = face_at(area_below_.back() * random.uniform());
      const double radius = diagonal_ * random.uniform(0.01, 0.03);
      if (gone_[first] == 0) cut_patch(first, radius);
    }
    return std::move(gone_);
  }

 private:
  [[nodiscard]] double area(const glm::uvec3& face) const { return 0.5 * glm::length(area_vector(mesh_, face)); }

  [[nodiscard]] std::uint32_t face_at(double area) const {
    const auto after = std::upper_bound(area_below_.begin() + 1, area_below_.end() - 1, area);
    return static_cast<std::uint32_t>(after - area_below_.begin()) - 1;
  }

  // The nearest faces go first, so that the last patch is round too, however soon enough is gone.
  void cut_patch(std::uint32_t first, double radius) {
    using Reached = std::pair<double, std::uint32_t>;  // distance, face
    const dvec3 middle = centroid(mesh_, mesh_.faces[first]);
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> reached;
    reached.emplace(0, first);
    while (!reached.empty() && left_ > 0) {
      const auto [distance, face] = reached.top();
      reached.pop();
      if (gone_[face] != 0) continue;
      const double part = area(mesh_.faces[face]);
      left_ -= part > 2 * left_ ? left_ : part;  // a face that takes the share further from what is asked for stays
      if (left_ == 0) return;
      gone_[face] = 1;
      for (const std::uint32_t next : neighbours_[face]) {
        const double away = glm::distance(centroid(mesh_, mesh_.faces[next]), middle);
        if (gone_[next] == 0 && away < radius) reached.emplace(away, next);
      }
    }
  }

  const Mesh& mesh_;
  std::vector<std::vector<std::uint32_t>> neighbours_;
  std::vector<double> area_below_{0};  // each face, and all of them
  std::vector<char> gone_;             // 1: cut out
  double diagonal_ = 0;
  double left_ = 0;  // area that is still to go
};

}  // namespace

Mesh with_mesh_noise(Mesh mesh, double rms, std::uint64_t seed) {
  std::vector<dvec3> normals(mesh.positions.size(), dvec3(0.0));
  for (const glm::uvec3& face : mesh.faces) {
    for (int corner = 0; corner < 3; ++corner) normals[face[corner]] += area_vector(mesh, face);
  }
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const double length = glm::length(normals[i]);
    if (length == 0) continue;
    Random random(hashed(seed, kMeshNoise, i));
    mesh.positions[i] = glm::vec3(dvec3(mesh.positions[i]) + rms * gaussian(random) / length * normals[i]);
  }
  return mesh;
}

Mesh with_holes(const Mesh& mesh, double share, std::uint64_t seed) {
  const std::vector<char> gone = HoleCutter(mesh).cut(share, Random(hashed(seed, kHoles)));
  TriangleSoup rest;
  rest.positions.assign(mesh.positions.begin(), mesh.positions.end());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    if (gone[i] == 0) rest.faces.push_back(mesh.faces[i]);
  }
  return repair(rest, dvec3(0.0)).mesh;
}

Mesh with_mesh_errors(Mesh mesh, const SynthOptions& options) {
  const SynthDisturbances& asked = options.disturbances;
  if (asked.mesh_noise > 0) mesh = with_mesh_noise(std::move(mesh), asked.mesh_noise, options.seed);
  if (asked.holes > 0) mesh = with_holes(mesh, asked.holes, options.seed);
  if (asked.decimate < 1) {
    const double faces = std::round(asked.decimate * static_cast<double>(mesh.faces.size()));
    mesh = decimated(mesh, static_cast<std::size_t>(std::max(faces, 1.0)));
  }
  return mesh;
}

}  // namespace lumatlas::synth
