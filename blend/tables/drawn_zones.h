// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the mesh of a surface as it is drawn, in batches of chunks. The mesh of a batch is copied to the
// GPU once. Of a surface that follows another, chunks that have not changed stay in the batch that they are in, and the
// others come into a new one.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "atlas/colors/fallback_colors.h"
#include "atlas/grid_chunks.h"
#include "blend/tables/cell_runs.h"
#include "blend/tables/fade_zone_shares.h"
#include "blend/tables/ranked_references.h"
#include "blend/tables/zone_mesh.h"
#include "mesh/camera/camera.h"

namespace lumatlas {

// Faces of a batch, one after another, with a ball around them.
struct BallOfFaces {
  FaceRun faces;
  Ball ball;
};

inline constexpr std::uint32_t kFacesOfRun = 1024;  // at most

// A chunk as it is in its batch. It stays the same under all surfaces that the chunk is in.
struct ChunkLayout {
  std::uint32_t first_zone, first_vertex;                            // of the batch
  ZoneCells zone_cells;                                              // cells are numbers in DrawnChunk::names
  std::vector<Ball> balls;                                           // around the faces of each combination of cells
  std::vector<CornerOfCell> sources;                                 // for each vertex, what it copies
  std::array<std::vector<BallOfFaces>, kCellsOfShader.size()> runs;  // in the order of kCellsOfShader
};

// Consecutive faces of a batch.
struct DrawnRun {
  std::uint32_t batch;  // of DrawnZones
  FaceRun faces;
};
using RunsOfShaders = std::array<std::vector<DrawnRun>, kCellsOfShader.size()>;

struct DrawnChunk {
  std::uint64_t cube = 0;     // see GridChunk
  std::uint64_t content = 0;  // a hash of all that its layout depends on
  std::vector<CellId> cells;
  std::shared_ptr<const std::vector<CellId>> names;  // cells of the surface that its layout may name
  std::shared_ptr<const ChunkLayout> layout;
  std::uint32_t batch = 0;  // of DrawnZones
};

struct DrawnBatch {
  std::uint64_t number = 0;                 // no other batch of the program has it
  std::uint32_t first_zone = 0, zones = 0;  // in the table of zones
  std::vector<std::uint32_t> sources;       // for each vertex the surface's that it copies; none: it is not drawn
};

struct DrawnZones {
  std::shared_ptr<const Surface> surface;
  double border_width = 0;
  bool is_joined = false;           // cells that refer to the same views were joined
  bool can_follow = false;          // chunks of this surface may stay under the next one
  std::vector<DrawnChunk> chunks;   // in the order of their cubes
  std::vector<DrawnBatch> batches;  // those of the surface before come first, in their order
  ZoneCells cells;                  // of all batches
  std::vector<Ball> balls;          // around the faces of each combination of cells

  // Returns ascending runs of each chunk's faces, with all that have a part in the image and in front of the camera,
  // and as few others as a ball around each kFacesOfRun faces can tell.
  [[nodiscard]] RunsOfShaders in_view(const Camera& camera) const;
};

// The mesh of a surface, and what is known of it afterwards.
struct MadeZones {
  std::optional<ZoneMesh> mesh;  // of the last batch, without colours; none: no batch is new
  std::shared_ptr<const DrawnZones> zones;
};

// Options of make_zones().
struct ZoneOptions {
  double border_width = 0;  // of BlendOptions
  // For each cell of the surface the one that stands for it, as of joined(); empty: none are joined.
  std::vector<std::uint32_t> stands_for;
  bool will_change = false;  // the surface follows another, and others may follow it
  // The shares of all cells, as of share_cells() with this width; null: they are made where they are needed.
  std::shared_ptr<const CellShares> shares;
};

// `former`: what was made of a former surface, or null.
[[nodiscard]] MadeZones make_zones(const std::shared_ptr<const Surface>& surface, const ZoneOptions& options,
                                   const DrawnZones* former);

// Returns the zones of a surface that differs from that of `former` in the places of its vertices and cells alone. They
// are drawn by the batches that are there, with copied_positions(). Shares of cells stay, although widths on the
// surface may have changed; balls grow by as much as a chunk's vertices have moved apart. Returns null for another
// surface or width, and where cells were joined.
[[nodiscard]] std::shared_ptr<const DrawnZones> moved_zones(const std::shared_ptr<const Surface>& surface,
                                                            double border_width, const DrawnZones& former);

// Returns the positions of the vertices of a batch.
[[nodiscard]] std::vector<glm::vec3> copied_positions(const Mesh& mesh, const DrawnBatch& batch);
// Returns the colours of the vertices of a batch.
[[nodiscard]] std::vector<glm::u8vec3> copied_colors(const FallbackColors& colors, const DrawnBatch& batch);

}  // namespace lumatlas
