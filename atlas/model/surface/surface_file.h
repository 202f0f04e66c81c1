// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: the glTF file of a model's surface, or of one of its chunks, with every check that a hostile file
// needs. Cells, vertices and faces have the chunk's own numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "atlas/model/gltf/gltf_file.h"
#include "atlas/reference_table.h"
#include "atlas/surface.h"
#include "mesh/mesh.h"

namespace lumatlas {

// The far sphere in a file: the number of its mesh, and its number of cells. Both are 0 where there is none.
struct FarPart {
  std::size_t mesh = 0;
  std::uint32_t cells = 0;
};

struct ChunkSurface {
  Mesh mesh;  // of the near surface, without copies of vertices, in the model's frame
  std::vector<CellId> cell_of_face;
  std::size_t near_cells = 0;
  FarPart far;
  glm::dvec3 offset{0.0};
  // The first mesh's vertices in the file, and how many of them are copies. The copies are the last.
  std::size_t written_vertices = 0, copies = 0;
};

class SurfaceFile {
 public:
  explicit SurfaceFile(const std::filesystem::path& path);

  [[nodiscard]] const GltfFile& gltf() const { return file_; }
  [[nodiscard]] const GltfFile::Object& lumigraph() const { return lumigraph_; }
  [[nodiscard]] bool textured() const;  // it has a base texture

  [[nodiscard]] ChunkSurface surface() const;
  // `cells`: all of the chunk, without guests.
  [[nodiscard]] FarSphere far_sphere(const FarPart& part, std::size_t cells, double cell_size) const;
  [[nodiscard]] double cell_size(double most) const;
  [[nodiscard]] std::vector<std::uint8_t> cells_seen() const;  // one per cell of the chunk
  [[nodiscard]] std::vector<glm::u8vec3> colors(std::size_t vertices, std::size_t copies) const;  // without the copies'
  [[nodiscard]] std::vector<glm::u8vec3> far_colors(std::size_t mesh, std::size_t vertices) const;
  // The references of guest cells follow those of the chunk's `own_cells`.
  [[nodiscard]] ReferenceTable references(std::size_t own_cells, std::size_t views) const;
  // Reads the accessor `name`, one number per cell; empty where the file has none.
  [[nodiscard]] std::vector<float> numbers_of_cells(const char* name, std::size_t cells) const;
  [[nodiscard]] std::vector<std::uint8_t> resident() const;  // as in the file; none where it has none
  // Refuses zones that are of no cell: a page reads them. The renderer makes its own.
  void require_zones(std::size_t own_cells) const;
  [[nodiscard]] std::size_t zone_numbers() const { return has("zoneCells") ? whole_numbers("zoneCells").size() : 0; }
  [[nodiscard]] std::optional<GltfImage> texture(std::size_t vertices) const;
  [[nodiscard]] bool has(const char* name) const { return lumigraph_.Has(name); }
  // Returns the `count` numbers that the runs of an accessor stand for.
  [[nodiscard]] std::vector<std::uint32_t> numbers_of_runs(const char* name, std::size_t count) const;

 private:
  [[nodiscard]] std::vector<std::uint32_t> whole_numbers(const char* name) const;
  [[nodiscard]] FarPart far_part(std::size_t cells) const;
  [[nodiscard]] Mesh written_mesh(std::size_t number = 0) const;
  [[nodiscard]] std::vector<std::uint32_t> copies(const Mesh& written) const;
  [[nodiscard]] std::vector<CellId> cell_of_vertex(std::size_t vertices, std::size_t first, std::size_t count,
                                                   std::size_t mesh) const;
  [[nodiscard]] std::vector<CellId> cell_of_face(const Mesh& written, std::size_t first, std::size_t count,
                                                 std::size_t mesh) const;
  void require_no_empty_cell(const std::vector<CellId>& of_face, std::size_t first, std::size_t count) const;
  void add_colors(const char* name, std::size_t mesh, std::size_t vertices, std::size_t copies,
                  std::vector<glm::u8vec3>& colors) const;
  void move_by_origin(std::vector<glm::vec3>& positions) const;
  [[nodiscard]] std::uint32_t guest_cells() const;
  [[nodiscard]] int texture_number() const;
  void require_zones_of_mesh(std::size_t mesh, std::size_t zones) const;
  void require_each_view_once(const ReferenceTable& table, std::size_t views) const;

  GltfFile file_;
  const GltfFile::Object& lumigraph_;  // in file_
};

}  // namespace lumatlas
