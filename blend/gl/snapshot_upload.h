// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the half of a snapshot's way to the GPU that OpenGL does, in steps of well below a millisecond on
// the thread that draws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "blend/gl/gl_objects.h"
#include "blend/gl/gradual_copies.h"
#include "blend/gl/mesh_objects.h"
#include "blend/gl/photograph_array.h"
#include "blend/gl/side_thread.h"
#include "blend/next_snapshot.h"
#include "blend/tables/snapshot_preparation.h"

namespace lumatlas {

inline constexpr const char* kViewsName = "numbers of its views";
inline constexpr const char* kReferencesName = "references";
inline constexpr const char* kZonesName = "zones of cells that fade into each other";
inline constexpr const char* kCellsName = "cells";

class SnapshotUpload {
 public:
  // `side`, which must outlive this object, allocates what takes more than `bytes_allocated_here`, if it has a context;
  // else step() does that.
  SnapshotUpload(std::shared_ptr<SnapshotPreparation> preparation, SideThread& side, std::uint64_t bytes_allocated_here)
      : preparation_(std::move(preparation)), side_(side), bytes_allocated_here_(bytes_allocated_here) {}

  enum class Progress { waits, goes_on, whole };
  // Does one step: `waits` if there is nothing to do before another thread has done more, `whole` once all is on the
  // GPU. Expects the state that GlStateGuard sets. Throws GlError, and what the preparation has thrown.
  [[nodiscard]] Progress step(PhotographArray& array);
  // Returns whether the next step() may allocate an array beside the one that is drawn: memory had better be freed.
  [[nodiscard]] bool allocates_array() const { return stage_ == Stage::listed && preparation_->array().is_new; }
  // Returns what the last step() did.
  [[nodiscard]] const UploadStep& last_step() const { return last_step_; }

  // Returns whether the views' numbers are in a uniform block, once step() has returned `whole`.
  [[nodiscard]] bool views_in_block() const { return objects_.views_block.has_value(); }
  [[nodiscard]] SnapshotPreparation& preparation() const { return *preparation_; }
  [[nodiscard]] std::shared_ptr<SnapshotPreparation> shared_preparation() const { return preparation_; }

  // The objects of the snapshot once step() has returned `whole`; before, a part of them. Empty ones: the former
  // snapshot's stay.
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
  // Objects without their contents.
  struct Allocated {
    ArrayTextures textures;
    std::vector<GlBuffer> buffers;  // as buffers_
    std::vector<GlTexture> tables;  // as tables_
  };
  // Copies that follow one another: buffers, then tables.
  struct BufferCopy {
    GradualBuffer gradual;
    GlBuffer* to;
  };
  struct TableCopy {
    GradualTable gradual;
    GlTexture* to;  // null: the other one
    std::optional<GlTable>* to_table;
    std::vector<std::byte> entries;  // for a GlTable
  };
  enum class Stage { preparing, listed, allocating, allocated };

  void list_copies();
  [[nodiscard]] std::uint64_t bytes_to_allocate();
  [[nodiscard]] Progress allocate();
  void ask_side();
  void use(Allocated allocated);
  [[nodiscard]] bool copy_page(const PhotographArray& array);
  [[nodiscard]] bool copy_buffer();
  [[nodiscard]] bool copy_table();
  [[nodiscard]] Progress copy_tile(PhotographArray& array);
  void list_tile_entries();

  std::shared_ptr<SnapshotPreparation> preparation_;
  SideThread& side_;
  std::uint64_t bytes_allocated_here_;
  Objects objects_;
  Stage stage_ = Stage::preparing;
  UploadStep last_step_;
  std::future<Allocated> allocated_;
  std::uint32_t copied_pages_ = 0, copied_rows_ = 0;  // rows: of the next page
  std::vector<BufferCopy> buffers_;
  std::vector<TableCopy> tables_;
  std::vector<glm::vec4> views_in_block_;
  std::size_t copied_buffers_ = 0, copied_tables_ = 0;
  std::optional<TileUpload> tile_;
  std::uint64_t copied_of_tile_ = 0;
  bool tiles_are_there_ = false;  // and tables_ has the bytes of their places
};

}  // namespace lumatlas
