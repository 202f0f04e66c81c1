// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/snapshot_upload.h"

#include <chrono>
#include <functional>

#include "blend/gl/egl_context.h"
#include "blend/tables/view_table.h"

namespace lumatlas {

// Lists the buffers and tables that are copied. The table of the tiles' places is the last one: see copy_table().
void SnapshotUpload::list_copies() {
  PreparedTables& prepared = preparation_->tables();
  if (prepared.mesh) {
    const ZoneMesh& mesh = *prepared.mesh;
    MeshObjects& to = objects_.mesh.emplace();
    buffers_.push_back({GradualBuffer(mesh.positions), &to.positions});
    buffers_.push_back({GradualBuffer(mesh.colors), &to.colors});
    buffers_.push_back({GradualBuffer(mesh.shares), &to.shares});
    buffers_.push_back({GradualBuffer(mesh.zones), &to.zone_numbers});
    buffers_.push_back({GradualBuffer(mesh.faces), &to.faces});
  }
  objects_.positions.resize(prepared.positions.size());
  for (std::size_t i = 0; i < prepared.positions.size(); ++i) {
    buffers_.push_back({GradualBuffer(prepared.positions[i]), &objects_.positions[i]});
  }
  objects_.colors.resize(prepared.colors.size());
  for (std::size_t i = 0; i < prepared.colors.size(); ++i) {
    buffers_.push_back({GradualBuffer(prepared.colors[i]), &objects_.colors[i]});
  }
  if (prepared.lists != preparation_->former().lists) {
    tables_.push_back({{kRecords, kZonesName, prepared.lists->zones}, &objects_.zones, nullptr, {}});
    tables_.push_back({{kRecords, kCellsName, prepared.lists->cells}, &objects_.cells, nullptr, {}});
  }
  tables_.push_back({{kPairs, kReferencesName, prepared.references},
                     nullptr,
                     &objects_.references,
                     std::move(prepared.reference_bytes)});
  if (prepared.views.size() > kBlockTexels) {
    tables_.push_back(
        {{kVectors, kViewsName, prepared.views}, nullptr, &objects_.views, std::move(prepared.view_bytes)});
  } else {
    views_in_block_ = prepared.views;
    views_in_block_.resize(kBlockTexels);
    buffers_.push_back({GradualBuffer(views_in_block_), &objects_.views_block.emplace()});
  }
  tables_.push_back({PhotographArray::gradual_tile_table(preparation_->array().contents.tile_entries),
                     nullptr,
                     &objects_.tile_entries,
                     {}});
}

std::uint64_t SnapshotUpload::bytes_to_allocate() {
  const NextArray& array = preparation_->array();
  std::uint64_t bytes = array.is_new ? array.contents.shape.bytes() : 0;
  for (const BufferCopy& copy : buffers_) bytes += copy.gradual.bytes();
  for (const TableCopy& copy : tables_) bytes += copy.gradual.bytes();
  return bytes;
}

// Allocates what is large: on the other thread if it can, else here, where buffers and tables are allocated one by one
// as they are copied.
SnapshotUpload::Progress SnapshotUpload::allocate() {
  const NextArray& array = preparation_->array();
  if (stage_ == Stage::listed) {
    const std::uint64_t bytes = bytes_to_allocate();
    const std::optional<bool> aside = bytes > bytes_allocated_here_ ? side_.has_context() : false;
    if (!aside) return Progress::waits;
    last_step_ = {"allocation", 0};
    if (*aside) {
      ask_side();
      stage_ = Stage::allocating;
      return Progress::goes_on;
    }
  } else {
    if (allocated_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return Progress::waits;
    if (preparation_->is_cancelled()) return Progress::waits;  // nothing may have been allocated
    last_step_ = {"allocation", 0};
    stage_ = Stage::allocated;
    try {
      use(allocated_.get());
      return Progress::goes_on;
    } catch (const GlError&) {  // the thread that draws may do better
    }
  }
  if (array.is_new) {
    last_step_.bytes = array.contents.shape.bytes();
    objects_.textures = PhotographArray::allocate_next(array.contents.shape);
  }
  stage_ = Stage::allocated;
  return Progress::goes_on;
}

void SnapshotUpload::ask_side() {
  std::optional<ArrayShape> shape;
  if (preparation_->array().is_new) shape = preparation_->array().contents.shape;
  std::vector<std::size_t> buffers;
  for (const BufferCopy& copy : buffers_) buffers.push_back(copy.gradual.bytes());
  std::vector<std::function<GlTexture()>> tables;
  for (const TableCopy& copy : tables_) tables.push_back(copy.gradual.allocation());
  allocated_ = side_.make([shape, buffers = std::move(buffers), tables = std::move(tables), asker = preparation_] {
    Allocated allocated;
    if (asker->is_cancelled()) return allocated;
    if (shape) allocated.textures = PhotographArray::allocate_next(*shape);
    for (const std::size_t bytes : buffers) {
      allocated.buffers.push_back(bytes > 0 ? allocate_buffer(bytes) : GlBuffer());
    }
    for (const auto& allocate_table : tables) allocated.tables.push_back(allocate_table());
    return allocated;
  });
}

void SnapshotUpload::use(Allocated allocated) {
  objects_.textures = std::move(allocated.textures);
  // Textures that another context has made must be bound before they are used. Copies between arrays do not bind them.
  for (const GlTexture* texture : {&objects_.textures.photographs, &objects_.textures.depths}) {
    if (texture->get() != 0) glBindTexture(GL_TEXTURE_2D_ARRAY, texture->get());
  }
  for (std::size_t i = 0; i < buffers_.size(); ++i) buffers_[i].gradual.use(std::move(allocated.buffers[i]));
  for (std::size_t i = 0; i < tables_.size(); ++i) tables_[i].gradual.use(std::move(allocated.tables[i]));
}

// Copies rows of a page of the array to the one that replaces it. Returns false if all are there.
bool SnapshotUpload::copy_page(const PhotographArray& array) {
  if (copied_pages_ == preparation_->array().copied_pages) return false;
  const auto [rows, bytes] = array.copy_page_rows(objects_.textures, copied_pages_, copied_rows_);
  last_step_ = {"page", bytes};
  copied_rows_ += rows;
  if (copied_rows_ == array.page_rows()) {
    copied_rows_ = 0;
    ++copied_pages_;
  }
  return true;
}

// Copies a piece of a buffer. Returns false if all are there.
bool SnapshotUpload::copy_buffer() {
  if (copied_buffers_ == buffers_.size()) return false;
  auto& [gradual, to] = buffers_[copied_buffers_];
  const std::size_t before = gradual.copied_bytes();
  const bool is_whole = gradual.copy_some();
  last_step_ = {"buffer", gradual.copied_bytes() - before};
  if (is_whole) {
    *to = gradual.take();
    ++copied_buffers_;
  }
  return true;
}

// Copies rows of a table. Returns false if all are there, except the tiles' places as long as tiles are prepared.
bool SnapshotUpload::copy_table() {
  if (copied_tables_ == tables_.size() - (tiles_are_there_ ? 0 : 1)) return false;
  auto& [gradual, to, to_table, entries] = tables_[copied_tables_];
  const std::uint64_t before = gradual.copied_bytes();
  const bool is_whole = gradual.copy_some();
  last_step_ = {"table", gradual.copied_bytes() - before};
  if (is_whole) {
    if (to != nullptr) {
      *to = gradual.take();
    } else {
      to_table->emplace(gradual.take_table(std::move(entries)));
    }
    ++copied_tables_;
  }
  return true;
}

// Copies rows of a tile; `whole` once all tiles are there.
SnapshotUpload::Progress SnapshotUpload::copy_tile(PhotographArray& array) {
  if (!tile_) {
    tile_ = preparation_->next_tile();
    copied_of_tile_ = 0;
  }
  if (!tile_) return preparation_->is_whole() ? Progress::whole : Progress::waits;
  const std::uint64_t before = copied_of_tile_;
  copied_of_tile_ = array.copy_band(objects_.textures, preparation_->array().contents.shape, *tile_, before);
  last_step_ = {"tile", copied_of_tile_ - before};
  if (const std::uint64_t all = tile_->bytes(); copied_of_tile_ == all) {
    tile_.reset();
    preparation_->give_back(all);
  }
  return Progress::goes_on;
}

// Lets copy_table() copy the tiles' places, which do not change any more.
void SnapshotUpload::list_tile_entries() {
  tables_.back().entries = std::move(preparation_->tables().tile_entry_bytes);
  tiles_are_there_ = true;
}

SnapshotUpload::Progress SnapshotUpload::step(PhotographArray& array) {
  last_step_ = {"wait", 0};
  switch (stage_) {
    case Stage::preparing:
      if (!preparation_->is_planned()) return Progress::waits;
      last_step_ = {"list", 0};
      list_copies();
      stage_ = Stage::listed;
      return Progress::goes_on;
    case Stage::listed:
    case Stage::allocating:
      return allocate();
    case Stage::allocated:
      break;
  }
  if (copy_page(array) || copy_buffer() || copy_table()) return Progress::goes_on;
  if (objects_.tile_entries) return Progress::whole;
  const Progress progress = copy_tile(array);
  if (progress != Progress::whole) return progress;
  last_step_ = {"list", 0};
  list_tile_entries();
  return Progress::goes_on;
}

}  // namespace lumatlas
