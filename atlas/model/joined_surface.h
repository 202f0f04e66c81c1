// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: joins the chunks of a model to its one surface and its tables, with every check that hostile
// files need.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <memory>
#include <vector>

#include "atlas/model/surface_file.h"
#include "atlas/reference_table.h"
#include "atlas/surface.h"

namespace lumatlas {

class JoinedSurface {
 public:
  // `files`: one or more, which must live as long as this object. Throws InputError naming the first file that does not
  // fit to the others: each cell, vertex and face of the surface is in one chunk, and one of them at most has the far
  // sphere.
  explicit JoinedSurface(const std::vector<std::unique_ptr<SurfaceFile>>& files);

  [[nodiscard]] const std::shared_ptr<const Surface>& surface() const { return surface_; }

  // Tables of the whole surface.
  [[nodiscard]] std::vector<std::uint8_t> cells_seen() const;
  [[nodiscard]] ReferenceTable references(std::size_t views) const;
  [[nodiscard]] std::vector<float> numbers_of_cells(const char* name) const;  // empty where no file has them
  [[nodiscard]] std::vector<glm::u8vec3> vertex_colors() const;

  // Counts over the files, with copies.
  [[nodiscard]] std::size_t written_vertices() const;
  [[nodiscard]] std::size_t copies() const;
  // Returns the vertices of one file's first mesh, with copies.
  [[nodiscard]] std::size_t written_vertices_of(std::size_t file) const { return chunks_[file].written_vertices; }
  [[nodiscard]] std::size_t cells_of(std::size_t file) const;  // of one file, without guests

 private:
  using Numbers = std::vector<std::vector<std::uint32_t>>;  // for each chunk, the numbers of its elements in the model
  [[nodiscard]] Numbers numbers(const char* name, const std::vector<std::size_t>& counts) const;
  void require_alike() const;
  [[nodiscard]] Surface near_surface_of_chunks() const;
  [[nodiscard]] std::size_t far_file() const;  // the number of the file with the far sphere; that of all without
  // Brings values of each chunk's cells to the cells of the model.
  template <typename T, typename ValuesOf>
  [[nodiscard]] std::vector<T> by_cell(const ValuesOf& values_of) const;

  const std::vector<std::unique_ptr<SurfaceFile>>& files_;
  std::vector<ChunkSurface> chunks_;
  Numbers cells_, vertices_, faces_;
  std::size_t near_cells_ = 0, near_vertices_ = 0, near_faces_ = 0;
  std::shared_ptr<const Surface> surface_;
};

}  // namespace lumatlas
