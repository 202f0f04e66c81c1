// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/city_surface.h"

#include <memory>
#include <string>

#include "atlas/model/model_file.h"
#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

fs::path piece_folder(const fs::path& plan, std::size_t number) {
  return surface_folder(plan) / std::to_string(number);
}

}  // namespace

CitySurface::CitySurface(const fs::path& plan) : folder_(surface_folder(plan)) {
  for (std::size_t piece = 0; fs::exists(piece_folder(plan, piece)); ++piece) {
    const std::vector<fs::path> files = chunk_files(piece_folder(plan, piece));
    files_.insert(files_.end(), files.begin(), files.end());
    chunks_of_pieces_.push_back(files.size());
  }
}

ChunkedSurface CitySurface::read(std::span<const std::size_t> chunks) const {
  std::vector<fs::path> files;
  for (const std::size_t chunk : chunks) {
    if (chunk >= files_.size()) {
      throw InputError(folder_.string() + ": has " + std::to_string(files_.size()) + " chunks, chunk " +
                       std::to_string(chunk) + " is asked for: plan the city again");
    }
    files.push_back(files_[chunk]);
  }
  return read_chunks(files);
}

void write_surface_piece(const fs::path& plan, std::size_t number, const Surface& surface, std::size_t chunk_faces) {
  Snapshot snapshot;
  snapshot.surface = std::make_shared<const Surface>(surface);
  snapshot.references.offsets.assign(surface.cells.cells.size() + 1, 0);
  snapshot.cell_seen.assign(surface.cells.cells.size(), 0);
  snapshot.vertex_colors = FallbackColors::Colors(surface.mesh.positions.size(), glm::u8vec3(128));
  snapshot.tiles.options = kWholeViews;
  FormOptions form;
  form.chunk_faces = chunk_faces;
  form.coarse_faces = 0;
  fs::create_directories(piece_folder(plan, number));
  write_model(piece_folder(plan, number), snapshot, {}, form);
}

void clear_surface(const fs::path& plan) {
  std::error_code error;
  fs::remove_all(surface_folder(plan), error);
  if (error) throw InputError(surface_folder(plan).string() + ": cannot be removed: " + error.message());
}

std::vector<CityChunk> describe_chunks(const ChunkedSurface& surface) {
  const Mesh& mesh = surface.surface.mesh;
  std::vector<CityChunk> chunks;
  std::size_t face = 0;
  for (const ChunkCounts& size : surface.chunks) {
    CityChunk chunk{size, {}};
    for (const std::size_t end = face + size.faces; face < end; ++face) {
      for (int corner = 0; corner < 3; ++corner) {
        chunk.box = with(chunk.box, glm::dvec3(mesh.positions[mesh.faces[face][corner]]));
      }
    }
    chunks.push_back(chunk);
  }
  return chunks;
}

}  // namespace lumatlas
