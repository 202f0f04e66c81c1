// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the half of a snapshot's way to the GPU that OpenGL does, in steps of well below a millisecond on
// the thread that draws.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "blend/gl/gl_objects.h"
#include "blend/gl/gradual_copies.h"
#include "blend/gl/mesh_objects.h"
#include "blend/gl/photograph_array.h"
#include "blend/tables/snapshot_preparation.h"

namespace lumatlas {

inline constexpr const char* kViewsName = "numbers of its views";
inline constexpr const char* kReferencesName = "references";
inline constexpr const char* kZonesName = "zones of cells that fade into each other";
inline constexpr const char* kCellsName = "cells";

class SnapshotUpload {
 public:
  explicit SnapshotUpload(std::shared_ptr<SnapshotPreparation> preparation) : preparation_(std::move(preparation)) {}

  enum class Progress { waits, goes_on, whole };
  // Does one step: `waits` if there is nothing to copy before more is prepared, `whole` once all is on the GPU. Expects
  // the state that GlStateGuard sets. Throws GlError, and what the preparation has thrown.
  [[nodiscard]] Progress step(PhotographArray& array);

  // Returns whether the views' numbers are in a uniform block, once step() has returned `whole`.
  [[nodiscard]] bool views_in_block() const { return objects_.views_block.has_value(); }
  [[nodiscard]] SnapshotPreparation& preparation() const { return *preparation_; }

  // What is there once step() has returned `whole`. Empty: what was there before stays.
  struct Objects {
    std::optional<MeshObjects> mesh;          // of the last batch
    std::vector<GlBuffer> positions, colors;  // of each batch that stays
    GlTexture zones, cells;
    std::optional<GlTable> references, views;
    std::optional<GlBuffer> views_block;
    ArrayTextures textures;
    std::optional<GlTable> tile_entries;
  };
  [[nodiscard]] Objects take() { return std::move(objects_); }

 private:
  void plan();
  [[nodiscard]] bool copy_tables();
  [[nodiscard]] Progress copy_tile(PhotographArray& array);

  std::shared_ptr<SnapshotPreparation> preparation_;
  Objects objects_;
  bool planned_ = false;
  std::uint32_t copied_pages_ = 0;
  // What is copied one after another: buffers, then tables.
  struct BufferCopy {
    GradualBuffer gradual;
    GlBuffer* to;
  };
  struct TableCopy {
    GradualTable gradual;
    GlTexture* to;  // null: the other one
    std::optional<GlTable>* to_table;
  };
  std::vector<BufferCopy> buffers_;
  std::vector<TableCopy> tables_;
  std::vector<glm::vec4> views_in_block_;
  std::size_t copied_buffers_ = 0, copied_tables_ = 0;
  std::optional<TileUpload> tile_;
  std::uint64_t copied_of_tile_ = 0;
};

}  // namespace lumatlas
