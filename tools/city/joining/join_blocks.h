// SPDX-License-Identifier: GPL-3.0-or-later
// Joins the blocks of a city to one model, whose surface is written block by block.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/gtc/type_precision.hpp>
#include <optional>
#include <vector>

#include "atlas/images/pixel_buffer.h"
#include "atlas/model/piecewise_model.h"
#include "atlas/views/validity.h"
#include "tools/budget/build_progress.h"
#include "tools/city/city_plan.h"
#include "tools/city/city_surface.h"

namespace lumatlas {

struct JoinOptions {
  std::size_t chunk_faces = 100'000;  // in a chunk of the model at most, unless one of the plan has more; >= 1
  std::uint32_t texture_px = 0;       // longest side of each chunk's base texture (baked_texture.h), or 0: none
};

// The tables and photographs of all blocks. The surface stays on disk until model() is written: memory holds some bytes
// a face, and photographs as far as PixelMemoryBound allows.
class JoinedCity {
 public:
  // Reads all blocks of a plan, each of which must be done (InputError naming the first that is not). `plan` must live
  // as long as this object.
  JoinedCity(std::filesystem::path folder, const CityPlan& plan, const JoinOptions& options,
             const BuildCallback& callback);

  // Returns the model, whose pieces this object makes: one for each block, with what lies around it, so that cells of
  // neighbouring blocks fade into each other as those of one block do. Views are sorted by name, each with the tiles
  // that any block needs of it. It can be written once.
  [[nodiscard]] PiecewiseModel model();

  [[nodiscard]] const ValidityOptions& validity() const { return validity_; }  // of the blocks' masks
  [[nodiscard]] std::size_t faces() const;                                     // those of the far sphere among them
  [[nodiscard]] std::size_t cells() const { return whole_.references.offsets.size() - 1; }
  [[nodiscard]] std::size_t views() const { return whole_.views.size(); }
  [[nodiscard]] std::uint32_t resident_tiles() const { return whole_.tiles.resident_tiles(); }
  // Returns how many chunks got no base texture, because it had no room for their charts.
  [[nodiscard]] std::size_t chunks_without_texture() const { return chunks_without_texture_; }

 private:
  // The colours that a block gives to the corners of its own faces, face by face.
  using CornerColors = PixelBuffer<glm::u8vec3>;

  void read_blocks(const BuildCallback& callback);
  void find_chunks();
  [[nodiscard]] SurfacePiece next_piece();
  [[nodiscard]] SurfacePiece piece(std::size_t block) const;
  [[nodiscard]] std::vector<std::size_t> chunks_around(std::size_t block) const;
  void add_tables(const std::vector<std::size_t>& chunks, SurfacePiece& piece) const;
  void add_colors(std::size_t block, SurfacePiece& piece) const;
  void add_textures(SurfacePiece& piece);

  std::filesystem::path folder_;
  const CityPlan& plan_;
  JoinOptions options_;
  BuildCallback callback_;
  std::optional<BuildStage> writing_;
  CitySurface surface_;
  FarSphere far_;
  ValidityOptions validity_;
  Snapshot whole_;                       // without a surface
  std::vector<CornerColors> colors_;     // one per block
  std::vector<std::size_t> first_cell_;  // of each chunk of the plan
  // The chunks of the model, by block: how many of the plan's each has.
  std::vector<std::vector<std::size_t>> chunks_;
  std::size_t next_block_ = 0, chunks_without_texture_ = 0;
};

}  // namespace lumatlas
