// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/surface/chunk_source.h"

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace lumatlas {

namespace {

// The chunks of a surface that is in memory.
class WholeSurface : public ChunkSource {
 public:
  WholeSurface(const ModelParts& model, const FormOptions& options)
      : maker_(model.snapshot, options.shares, options.texture ? &options.texture->faces : nullptr, options.chunk_faces,
               packed_step(model, options)) {}

  [[nodiscard]] std::size_t count() const override { return maker_.count(); }
  [[nodiscard]] SurfaceChunk chunk(std::size_t number) override { return maker_.chunk(number); }

 private:
  ChunkMaker maker_;
};

// The chunks of a surface that comes in pieces.
class SurfaceInPieces : public ChunkSource {
 public:
  SurfaceInPieces(const ModelParts& model, const PiecewiseSurface& surface, const FormOptions& options)
      : model_(model), surface_(surface), step_(packed_step(model, options)) {}

  [[nodiscard]] std::size_t count() const override { return surface_.chunks; }

  [[nodiscard]] SurfaceChunk chunk(std::size_t number) override {
    while (number - first_ >= piece_.chunks.size()) next_piece();
    const std::size_t in_piece = number - first_;
    SurfaceChunk chunk = maker_->chunk(in_piece);
    if (!piece_.textures.empty()) chunk.texture = piece_.textures[in_piece];
    chunk.cells.clear();
    chunk.vertices.clear();
    chunk.faces.clear();
    return chunk;
  }

 private:
  void next_piece() {
    first_ += piece_.chunks.size();
    maker_.reset();
    piece_ = {};
    piece_ = surface_.next();
    Snapshot& snapshot = piece_.snapshot;
    snapshot.views = model_.snapshot.views;
    snapshot.gains = model_.snapshot.gains;
    snapshot.tiles = model_.snapshot.tiles;
    check(snapshot);
    if (!piece_.textures.empty() && piece_.textures.size() != piece_.chunks.size()) {
      throw std::invalid_argument("pieces: there are " + std::to_string(piece_.textures.size()) + " textures for " +
                                  std::to_string(piece_.chunks.size()) + " chunks");
    }
    const CellShares* const shares = piece_.shares ? &*piece_.shares : nullptr;
    if (shares) check(*shares, snapshot.surface->mesh.faces.size(), snapshot.surface->cells.cells.size());
    if (surface_.chunks == 1) {
      maker_.emplace(snapshot, shares, nullptr, piece_.chunks, step_);
      return;
    }
    std::vector<std::vector<CellId>> chunks = piece_.chunks;
    chunks.push_back(cells_around(piece_));
    maker_.emplace(snapshot, shares, nullptr, std::move(chunks), step_);
  }

  // Returns the near cells that are in no chunk of the piece.
  static std::vector<CellId> cells_around(const SurfacePiece& piece) {
    std::vector<std::uint8_t> own(piece.snapshot.surface->near_cells(), 0);
    for (const std::vector<CellId>& chunk : piece.chunks) {
      for (const CellId cell : chunk) own[cell] = 1;
    }
    std::vector<CellId> around;
    for (CellId cell{0}; cell < own.size(); ++cell) {
      if (own[cell] == 0) around.push_back(cell);
    }
    return around;
  }

  const ModelParts& model_;
  const PiecewiseSurface& surface_;
  std::optional<double> step_;
  SurfacePiece piece_;
  std::size_t first_ = 0;  // number of the piece's first chunk
  std::optional<ChunkMaker> maker_;
};

}  // namespace

std::unique_ptr<ChunkSource> whole_surface(const ModelParts& model, const FormOptions& options) {
  return std::make_unique<WholeSurface>(model, options);
}

std::unique_ptr<ChunkSource> surface_in_pieces(const ModelParts& model, const PiecewiseSurface& surface,
                                               const FormOptions& options) {
  return std::make_unique<SurfaceInPieces>(model, surface, options);
}

}  // namespace lumatlas
