// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: cuts a model's surface into chunks, the pieces of bounded size in which it is written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "atlas/base_texture.h"
#include "atlas/fade_zones.h"
#include "atlas/snapshot.h"
#include "atlas/vertex_split.h"

namespace lumatlas {

// Returns the cells of each chunk, ascending. The cells of the near surface are halved by the median of their centroids
// along the longest axis of these, until each part has at most `most_faces` faces or one cell. The same for the same
// input. One chunk without cells where the surface has none.
[[nodiscard]] std::vector<std::vector<CellId>> cells_of_chunks(const Surface& surface, std::size_t most_faces);

// Returns the origin from which the positions of a chunk are counted. It lies near their middle, and position - origin
// as a float, plus origin, is the position to the bit. A coordinate is 0 where no other value is so exact.
[[nodiscard]] glm::dvec3 exact_origin(const std::vector<glm::vec3>& positions);

// A chunk as a model of its own. Cells, vertices and faces have numbers in it: own cells first, then those of the far
// sphere, if the chunk has it, then guests.
struct SurfaceChunk {
  // The views of the model; the references of guest cells follow those of the own ones. Positions less `origin`.
  Snapshot snapshot;
  std::optional<CellShares> shares;
  std::optional<TexturePlaces> places;
  glm::dvec3 origin{0.0};
  std::vector<std::uint32_t> guests;  // the model's numbers of cells of other chunks, with which faces of this one fade
  // The numbers of its own cells, vertices and faces in the model without the far sphere, ascending. None: they follow
  // those of the chunk before.
  std::vector<std::uint32_t> cells, vertices, faces;
  std::shared_ptr<const BaseTexture> texture;  // of its own; null: `places` are in the model's, if it has one
};

// Returns the mesh of a chunk's near surface in the model's frame, with the colours of its vertices.
[[nodiscard]] Mesh placed_mesh(const SurfaceChunk& chunk);

class ChunkMaker {
 public:
  // `shares` and `places` may be null. All must live as long as this object. `grid`: the width of a grid on which
  // positions are put first, as packed surfaces have them; none: they stay as they are.
  ChunkMaker(const Snapshot& snapshot, const CellShares* shares, const TexturePlaces* places, std::size_t most_faces,
             std::optional<double> grid);
  // `cells`: those of each chunk, as cells_of_chunks() returns them; each near cell is in one chunk.
  ChunkMaker(const Snapshot& snapshot, const CellShares* shares, const TexturePlaces* places,
             std::vector<std::vector<CellId>> cells, std::optional<double> grid);

  [[nodiscard]] std::size_t count() const { return cells_.size(); }
  // The far sphere is in the first chunk.
  [[nodiscard]] SurfaceChunk chunk(std::size_t number) const;

 private:
  void add_guests(SurfaceChunk& chunk) const;
  void add_tables(SurfaceChunk& chunk) const;
  [[nodiscard]] Surface near_part(SurfaceChunk& chunk, std::size_t number) const;

  const Snapshot& snapshot_;
  const CellShares* shares_;
  const TexturePlaces* places_;
  Mesh near_;                                              // its vertices are those of one cell each
  std::vector<std::uint32_t> sources_, number_of_vertex_;  // one per vertex: the given one, its number in its chunk
  std::vector<std::vector<CellId>> cells_;                 // one list per chunk, as the next two
  std::vector<std::vector<std::uint32_t>> vertices_of_chunk_, faces_of_chunk_;
  std::vector<std::uint32_t> chunk_of_cell_, number_in_chunk_;  // one per near cell
};

}  // namespace lumatlas
