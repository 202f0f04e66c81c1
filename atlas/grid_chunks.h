// SPDX-License-Identifier: GPL-3.0-or-later
// The cells of a surface in chunks, by the cubes of a grid that their centroids are in. What is made of a surface chunk
// by chunk, for a renderer or a page, stays where neither a chunk nor the surface around it has changed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "atlas/surface.h"

namespace lumatlas {

struct GridChunk {
  std::uint64_t cube = 0;     // its place on a Z-order curve through the scene
  std::vector<CellId> cells;  // ascending
};

// A corner of a face of a cell. The number of the face is that of its corners over 3, among those of the cell.
struct CornerOfCell {
  std::uint32_t cell;  // which of the chunk's
  std::uint32_t corner;
};

// The faces of each cell, ascending.
class FacesOfCells {
 public:
  FacesOfCells() = default;
  explicit FacesOfCells(const Cells& cells);

  [[nodiscard]] std::span<const std::uint32_t> of(CellId cell) const {
    return std::span(faces_).subspan(offsets_[cell], offsets_[cell + 1] - offsets_[cell]);
  }

 private:
  std::vector<std::uint32_t> offsets_, faces_;
};

// Returns a hash of 64 bits for each cell, of its faces' coordinates in their order.
[[nodiscard]] std::vector<std::uint64_t> hashes_of_cells(const Mesh& mesh, const FacesOfCells& faces,
                                                         std::size_t cells);
// Returns a hash of all that the shares of a chunk's cells depend on. `cells`: the chunk's; `around`: see
// GridChunks::around(); `hashes`: of all cells, as of hashes_of_cells().
[[nodiscard]] std::uint64_t hash_of_chunk(std::span<const CellId> cells, std::span<const CellId> around,
                                          std::span<const std::uint64_t> hashes);

class GridChunks {
 public:
  // The surface must outlive this. `cells_across`: side of a cube, in cell sizes, > 0.
  GridChunks(const Surface& surface, double cells_across);

  // Returns the chunks in the order of their cubes. Each has a cell.
  [[nodiscard]] const std::vector<GridChunk>& all() const { return chunks_; }

  // Returns the cells on whose faces the shares of the chunk's own may depend, ascending, its own among them: those
  // within `width`, as of share_cells(), of a cell that touches the chunk. Beyond these shares depend only on faces
  // that more than kCellsPerZone cells would share and that form a chain from there to the chunk.
  [[nodiscard]] std::vector<CellId> around(const GridChunk& chunk, double width) const;

  // Returns false for a surface with many cells that are larger than a chunk, where around() takes long.
  [[nodiscard]] bool are_even() const;

 private:
  using Cube = std::array<std::int32_t, 3>;
  struct Box {
    glm::dvec3 least, most;
  };

  // Finds chunks by their cubes.
  class CubeTable {
   public:
    CubeTable() = default;
    explicit CubeTable(const std::vector<GridChunk>& chunks);
    // Returns the number of the chunk, or of chunks where the cube has none.
    [[nodiscard]] std::uint32_t find(std::uint64_t cube) const;

   private:
    struct Entry {
      std::uint64_t cube;
      std::uint32_t chunk;
    };
    std::vector<Entry> entries_;
    std::uint32_t chunks_ = 0;
  };

  [[nodiscard]] Cube cube_of(const glm::dvec3& place) const;
  [[nodiscard]] Box box_of(std::span<const CellId> cells) const;
  [[nodiscard]] static bool are_apart(const Box& a, const Box& b, double distance);
  [[nodiscard]] std::vector<CellId> touching(const Box& box) const;

  const Surface& surface_;
  double side_ = 0;  // of a cube, scene units
  std::vector<GridChunk> chunks_;
  CubeTable chunk_of_cube_;
  std::vector<Box> boxes_;           // of each chunk, around its cells that are not large
  std::vector<CellId> large_cells_;  // ascending
};

// Returns a part of the surface: these cells, ascending, in their order, with their faces and the vertices of these.
[[nodiscard]] Surface part_of_cells(const Surface& surface, const FacesOfCells& faces, std::span<const CellId> cells);

}  // namespace lumatlas
