// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/city/: the mesh of a scene in pieces on disk, so that repairing it, cutting it into cells and
// looking at it take the memory of a piece.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "mesh/mesh.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

// Cuts faces at the median of their middles along the longest axis, until each part has at most `most_faces`, and calls
// use() with each part in order, the numbers of its faces ascending. The same for the same input.
void cut_faces(const Mesh& mesh, std::size_t most_faces,
               const std::function<void(const std::vector<std::uint32_t>& faces)>& use);

// Reads a mesh that write_ply() wrote, without colours.
[[nodiscard]] Mesh read_ply_mesh(const std::filesystem::path& file);

// Returns the mesh of these faces. Vertices keep their order; colours are left out.
[[nodiscard]] Mesh mesh_of_faces(const Mesh& mesh, const std::vector<std::uint32_t>& faces);

class MeshPieces {
 public:
  // Cuts the triangles, repairs each piece, and writes it into `folder`, which must exist and outlive this object.
  // Holds all triangles meanwhile, 45 bytes a face. Faces of two pieces that meet keep the same positions there.
  // `coarse_faces`: of coarse(), about. Throws InputError where no face is left, and Interrupted soon after a signal.
  MeshPieces(SoupInput input, std::size_t most_faces, std::size_t coarse_faces, std::filesystem::path folder);

  [[nodiscard]] std::size_t count() const { return files_.size(); }
  [[nodiscard]] Mesh read(std::size_t piece) const;
  [[nodiscard]] const glm::dvec3& offset() const { return offset_; }  // scene_origin(), subtracted from all
  [[nodiscard]] const SurfaceInput& facts() const { return facts_; }  // of the file
  // The whole mesh; with fewer faces, where it has more than coarse_faces.
  [[nodiscard]] const Mesh& coarse() const { return coarse_; }

 private:
  std::filesystem::path folder_;
  SurfaceInput facts_;
  glm::dvec3 offset_{0.0};
  Mesh coarse_;
  std::vector<std::filesystem::path> files_;
};

}  // namespace lumatlas
