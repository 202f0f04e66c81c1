// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/surface/joined_surface.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "atlas/model/model_extension.h"
#include "atlas/model/model_ranges.h"
#include "mesh/cells/cells.h"

namespace lumatlas {

JoinedSurface::JoinedSurface(const std::vector<std::unique_ptr<SurfaceFile>>& files) : files_(files) {
  for (const auto& file : files_) chunks_.push_back(file->surface());
  std::vector<std::size_t> cells, vertices, faces;
  for (const ChunkSurface& chunk : chunks_) {
    cells.push_back(chunk.near_cells);
    vertices.push_back(chunk.mesh.positions.size());
    faces.push_back(chunk.mesh.faces.size());
  }
  cells_ = numbers("cellRuns", cells);
  vertices_ = numbers("vertexRuns", vertices);
  faces_ = numbers("faceRuns", faces);
  near_cells_ = std::accumulate(cells.begin(), cells.end(), std::size_t{0});
  near_vertices_ = std::accumulate(vertices.begin(), vertices.end(), std::size_t{0});
  near_faces_ = std::accumulate(faces.begin(), faces.end(), std::size_t{0});
  require_alike();
  Surface surface = take_near_surfaces();
  if (const std::size_t far = far_file(); far < files_.size()) {
    surface = with_far_sphere(surface, files_[far]->far_sphere(chunks_[far].far, cells_of(far), surface.cells.size));
  }
  surface_ = std::make_shared<const Surface>(std::move(surface));
}

void JoinedSurface::require_all_or_none_have(const char* name) const {
  for (const auto& file : files_) {
    if (file->has(name) == files_.front()->has(name)) continue;
    file->gltf().refuse(std::string(file->has(name) ? "has " : "has no ") + name + ", unlike " +
                        files_.front()->gltf().path().filename().string());
  }
}

// Elements without numbers follow those of the files before.
JoinedSurface::Numbers JoinedSurface::numbers(const char* name, const std::vector<std::size_t>& counts) const {
  require_all_or_none_have(name);
  const std::size_t all = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
  std::vector<std::uint8_t> taken(all, 0);
  Numbers numbers;
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const SurfaceFile& file = *files_[i];
    std::vector<std::uint32_t>& of_file = numbers.emplace_back();
    if (file.has(name)) {
      of_file = file.numbers_of_runs(name, counts[i]);
    } else {
      of_file.resize(counts[i]);
      std::iota(of_file.begin(), of_file.end(), next);
      next += static_cast<std::uint32_t>(counts[i]);
    }
    for (const std::uint32_t number : of_file) {
      if (number < all && !std::exchange(taken[number], 1)) continue;
      file.gltf().refuse(std::string(name) + " has the number " + std::to_string(number) +
                         (number < all ? " a second time" : " of " + std::to_string(all)));
    }
  }
  return numbers;
}

void JoinedSurface::require_alike() const {
  std::size_t cells = near_cells_;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const GltfFile& file = files_[i]->gltf();
    const std::string first = files_.front()->gltf().path().filename().string();
    if (chunks_[i].offset != chunks_.front().offset) file.refuse("has another \"offset\" than " + first);
    if (chunks_[i].far.cells > 0 && i != far_file()) {
      file.refuse("has a far sphere, of which the model has one already");
    }
    cells += chunks_[i].far.cells;
  }
  if (cells > kMostCells) {
    files_.front()->gltf().refuse("has " + std::to_string(cells) +
                                  " cells with the model's other surfaces, must be at most " +
                                  std::to_string(kMostCells));
  }
}

Surface JoinedSurface::take_near_surfaces() {
  Surface surface;
  surface.offset = chunks_.front().offset;
  surface.mesh.positions.resize(near_vertices_);
  surface.mesh.faces.resize(near_faces_);
  std::vector<CellId> cell_of_face(near_faces_);
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    ChunkSurface& chunk = chunks_[i];
    const std::vector<std::uint32_t>& vertices = vertices_[i];
    for (std::size_t k = 0; k < vertices.size(); ++k) surface.mesh.positions[vertices[k]] = chunk.mesh.positions[k];
    for (std::size_t k = 0; k < faces_[i].size(); ++k) {
      const glm::uvec3& face = chunk.mesh.faces[k];
      surface.mesh.faces[faces_[i][k]] = {vertices[face.x], vertices[face.y], vertices[face.z]};
      cell_of_face[faces_[i][k]] = CellId(cells_[i][chunk.cell_of_face[k]]);
    }
    chunk.mesh = {};  // the joined surface has it now
    chunk.cell_of_face = {};
    faces_[i] = {};
  }
  const double most = most_cell_size(surface.mesh);
  const double size = files_.front()->cell_size(most);
  for (const auto& file : files_) {
    if (file->cell_size(most) == size) continue;
    file->gltf().refuse("has another \"cellSize\" than " + files_.front()->gltf().path().filename().string());
  }
  surface.cells = measure_cells(surface.mesh, std::move(cell_of_face), size);
  return surface;
}

std::size_t JoinedSurface::far_file() const {
  const auto has_far = [](const ChunkSurface& chunk) { return chunk.far.cells > 0; };
  return static_cast<std::size_t>(std::find_if(chunks_.begin(), chunks_.end(), has_far) - chunks_.begin());
}

std::size_t JoinedSurface::cells_of(std::size_t file) const {
  return chunks_[file].near_cells + chunks_[file].far.cells;
}

template <typename T, typename ValuesOf>
std::vector<T> JoinedSurface::by_cell(const ValuesOf& values_of) const {
  std::vector<T> all(surface_->cells.cells.size());
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const std::vector<T> values = values_of(i);
    for (std::size_t k = 0; k < cells_[i].size(); ++k) all[cells_[i][k]] = values[k];
    for (std::size_t k = 0; k < chunks_[i].far.cells; ++k) all[near_cells_ + k] = values[cells_[i].size() + k];
  }
  return all;
}

std::vector<std::uint8_t> JoinedSurface::cells_seen() const {
  return by_cell<std::uint8_t>([&](std::size_t file) { return files_[file]->cells_seen(); });
}

ReferenceTable JoinedSurface::references(std::size_t views) const {
  std::vector<ReferenceTable> tables;
  for (std::size_t i = 0; i < files_.size(); ++i) tables.push_back(files_[i]->references(cells_of(i), views));
  const auto lists = by_cell<std::span<const ViewSlot>>([&](std::size_t file) {
    std::vector<std::span<const ViewSlot>> of_cells;
    for (std::size_t cell = 0; cell < cells_of(file); ++cell) of_cells.push_back(tables[file].of_cell(cell));
    return of_cells;
  });
  ReferenceTable joined;
  for (const std::span<const ViewSlot> list : lists) {
    joined.views.insert(joined.views.end(), list.begin(), list.end());
    joined.offsets.push_back(static_cast<std::uint32_t>(joined.views.size()));
  }
  return joined;
}

std::vector<float> JoinedSurface::numbers_of_cells(const char* name) const {
  require_all_or_none_have(name);
  if (!files_.front()->has(name)) return {};
  return by_cell<float>([&](std::size_t file) { return files_[file]->numbers_of_cells(name, cells_of(file)); });
}

std::vector<glm::u8vec3> JoinedSurface::vertex_colors() const {
  std::vector<glm::u8vec3> colors(surface_->mesh.positions.size());
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const std::vector<glm::u8vec3> of_file = files_[i]->colors(chunks_[i].written_vertices, chunks_[i].copies);
    for (std::size_t k = 0; k < vertices_[i].size(); ++k) colors[vertices_[i][k]] = of_file[k];
    if (chunks_[i].far.cells == 0) continue;
    const std::vector<glm::u8vec3> far = files_[i]->far_colors(chunks_[i].far.mesh, surface_->far_vertices);
    std::copy(far.begin(), far.end(), colors.begin() + static_cast<std::ptrdiff_t>(near_vertices_));
  }
  return colors;
}

std::size_t JoinedSurface::written_vertices() const {
  std::size_t sum = 0;
  for (const ChunkSurface& chunk : chunks_) sum += chunk.written_vertices;
  return sum;
}

std::size_t JoinedSurface::copies() const {
  std::size_t sum = 0;
  for (const ChunkSurface& chunk : chunks_) sum += chunk.copies;
  return sum;
}

}  // namespace lumatlas
