// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: joins the chunks of a model to its one surface and its tables, with every check that hostile
// files need.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <memory>
#include <vector>

#include "atlas/model/surface/surface_file.h"
#include "atlas/reference_table.h"
#include "atlas/surface.h"

namespace lumatlas {

class JoinedSurface {
 public:
  // `files`: one or more, which must live as long as this object. Throws InputError naming the first file that breaks a
  // rule. Each cell, vertex and face must be in exactly one chunk, at most one chunk may have the far sphere, and all
  // must have the same offset and cell size.
  explicit JoinedSurface(const std::vector<std::unique_ptr<SurfaceFile>>& files);

  [[nodiscard]] const std::shared_ptr<const Surface>& surface() const { return surface_; }

  // The following return tables with one entry per cell of the surface, the cells of the far sphere last. They throw
  // InputError naming the file whose table breaks a rule.
  [[nodiscard]] std::vector<std::uint8_t> cells_seen() const;                 // 1: an offered view saw the cell
  [[nodiscard]] ReferenceTable references(std::size_t views) const;           // to view slots below `views`
  [[nodiscard]] std::vector<float> numbers_of_cells(const char* name) const;  // empty where no file has the accessor
  // Returns the sRGB colour of each vertex of the surface. Throws as they do.
  [[nodiscard]] std::vector<glm::u8vec3> vertex_colors() const;

  // Return how many vertices the first meshes of all files have, copies among them, and how many of these are copies.
  [[nodiscard]] std::size_t written_vertices() const;
  [[nodiscard]] std::size_t copies() const;
  // Return how many vertices the first mesh of one file has, copies among them, and how many cells of its own.
  [[nodiscard]] std::size_t written_vertices_of(std::size_t file) const { return chunks_[file].written_vertices; }
  [[nodiscard]] std::size_t cells_of(std::size_t file) const;

 private:
  using Numbers = std::vector<std::vector<std::uint32_t>>;  // for each chunk, the numbers of its elements in the model
  [[nodiscard]] Numbers numbers(const char* name, const std::vector<std::size_t>& counts) const;
  void require_alike() const;
  void require_all_or_none_have(const char* name) const;
  // Returns the joined near surface, and frees the meshes of the chunks.
  [[nodiscard]] Surface take_near_surfaces();
  // Returns the number of the file with the far sphere, or the number of files where there is none.
  [[nodiscard]] std::size_t far_file() const;
  // Returns the chunks' values of their own cells in the order of the model's cells.
  template <typename T, typename ValuesOf>
  [[nodiscard]] std::vector<T> by_cell(const ValuesOf& values_of) const;

  const std::vector<std::unique_ptr<SurfaceFile>>& files_;
  std::vector<ChunkSurface> chunks_;
  Numbers cells_, vertices_, faces_;
  std::size_t near_cells_ = 0, near_vertices_ = 0, near_faces_ = 0;
  std::shared_ptr<const Surface> surface_;
};

}  // namespace lumatlas
