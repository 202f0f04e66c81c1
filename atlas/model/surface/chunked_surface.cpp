// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/surface/chunked_surface.h"

#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "atlas/model/model_extension.h"
#include "atlas/model/model_form.h"
#include "atlas/model/surface/surface_file.h"
#include "atlas/model/tileset_file.h"
#include "mesh/repair/joined_faces.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kUnused = ~0u;

// Joins vertices at one position, and leaves out those that no face has then.
void join_vertices(Mesh& mesh) {
  mesh.faces = joined_faces(mesh);
  std::vector<std::uint32_t> number(mesh.positions.size(), kUnused);
  for (const glm::uvec3& face : mesh.faces) {
    for (int corner = 0; corner < 3; ++corner) number[face[corner]] = 0;
  }
  std::uint32_t next = 0;
  for (std::size_t vertex = 0; vertex < number.size(); ++vertex) {
    if (number[vertex] == kUnused) continue;
    mesh.positions[next] = mesh.positions[vertex];
    number[vertex] = next++;
  }
  mesh.positions.resize(next);
  for (glm::uvec3& face : mesh.faces) face = {number[face.x], number[face.y], number[face.z]};
}

void append(ChunkSurface chunk, ChunkedSurface& joined, std::vector<CellId>& cell_of_face, std::size_t& cells) {
  Mesh& mesh = joined.surface.mesh;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  joined.chunks.push_back({chunk.near_cells, chunk.mesh.faces.size()});
  mesh.positions.insert(mesh.positions.end(), chunk.mesh.positions.begin(), chunk.mesh.positions.end());
  for (const glm::uvec3& face : chunk.mesh.faces) mesh.faces.push_back(face + first);
  for (const CellId cell : chunk.cell_of_face) {
    cell_of_face.emplace_back(static_cast<std::uint32_t>(cells + std::uint32_t{cell}));
  }
  cells += chunk.near_cells;
}

}  // namespace

std::vector<fs::path> chunk_files(const fs::path& model) {
  return TilesetFile(fs::is_directory(model) ? model / kTilesetName : model).surfaces();
}

ChunkedSurface read_chunks(std::span<const fs::path> files) {
  if (files.empty()) throw std::invalid_argument("chunks: none are asked for, must be at least one");
  ChunkedSurface joined;
  std::vector<CellId> cell_of_face;
  std::unique_ptr<SurfaceFile> first;
  std::size_t cells = 0;
  for (const fs::path& path : files) {
    auto file = std::make_unique<SurfaceFile>(path);
    ChunkSurface chunk = file->surface();
    if (!first) {
      joined.surface.offset = chunk.offset;
    } else if (chunk.offset != joined.surface.offset) {
      file->gltf().refuse("has another \"offset\" than " + first->gltf().path().filename().string());
    }
    if (chunk.far.cells > 0) {
      const double size = file->cell_size(std::numeric_limits<double>::max());
      joined.far = file->far_sphere(chunk.far, chunk.near_cells + chunk.far.cells, size);
      join_vertices(joined.far.mesh);
    }
    append(std::move(chunk), joined, cell_of_face, cells);
    if (!first) first = std::move(file);
  }
  if (cells > kMostCells) {
    first->gltf().refuse("has " + std::to_string(cells) + " cells with the other chunks, must be at most " +
                         std::to_string(kMostCells));
  }
  join_vertices(joined.surface.mesh);
  // A chunk alone may be smaller than the size of a cell, which is checked where the whole model is read.
  const double size = first->cell_size(std::numeric_limits<double>::max());
  joined.surface.cells = measure_cells(joined.surface.mesh, std::move(cell_of_face), size);
  return joined;
}

}  // namespace lumatlas
