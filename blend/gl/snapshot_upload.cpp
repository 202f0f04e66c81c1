// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/snapshot_upload.h"

#include "blend/tables/view_table.h"

namespace lumatlas {

// Makes the textures that replace others, and lists what is copied.
void SnapshotUpload::plan() {
  PreparedTables& prepared = preparation_->tables();
  objects_.textures = PhotographArray::make_next(preparation_->array());
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
    tables_.push_back({{kRecords, kZonesName, prepared.lists->zones}, &objects_.zones, nullptr});
    tables_.push_back({{kRecords, kCellsName, prepared.lists->cells}, &objects_.cells, nullptr});
  }
  tables_.push_back({{kPairs, kReferencesName, prepared.references}, nullptr, &objects_.references});
  if (prepared.views.size() > kBlockTexels) {
    tables_.push_back({{kVectors, kViewsName, prepared.views}, nullptr, &objects_.views});
  } else {
    views_in_block_ = prepared.views;
    views_in_block_.resize(kBlockTexels);
    buffers_.push_back({GradualBuffer(views_in_block_), &objects_.views_block.emplace()});
  }
  planned_ = true;
}

// Copies a piece of a buffer or a table. Returns false if all are there.
bool SnapshotUpload::copy_tables() {
  if (copied_buffers_ < buffers_.size()) {
    auto& [gradual, to] = buffers_[copied_buffers_];
    if (gradual.copy_some()) {
      *to = gradual.take();
      ++copied_buffers_;
    }
    return true;
  }
  if (copied_tables_ < tables_.size()) {
    auto& [gradual, to, to_table] = tables_[copied_tables_];
    if (gradual.copy_some()) {
      if (to != nullptr) {
        *to = gradual.take();
      } else {
        to_table->emplace(gradual.take_table());
      }
      ++copied_tables_;
    }
    return true;
  }
  return false;
}

SnapshotUpload::Progress SnapshotUpload::copy_tile(PhotographArray& array) {
  if (!tile_) {
    tile_ = preparation_->next_tile();
    copied_of_tile_ = 0;
  }
  if (!tile_) return preparation_->is_whole() ? Progress::whole : Progress::waits;
  copied_of_tile_ = array.copy_band(objects_.textures, preparation_->array().contents.shape, *tile_, copied_of_tile_);
  if (const std::uint64_t all = tile_->bytes(); copied_of_tile_ == all) {
    tile_.reset();
    preparation_->give_back(all);
  }
  return Progress::goes_on;
}

SnapshotUpload::Progress SnapshotUpload::step(PhotographArray& array) {
  if (!planned_) {
    if (!preparation_->is_planned()) return Progress::waits;
    plan();
    return Progress::goes_on;
  }
  if (copied_pages_ < preparation_->array().copied_pages) {
    array.copy_page(objects_.textures, copied_pages_++);
    return Progress::goes_on;
  }
  if (copy_tables()) return Progress::goes_on;
  if (objects_.tile_entries) return Progress::whole;
  const Progress progress = copy_tile(array);
  if (progress != Progress::whole) return progress;
  GlTable entries = PhotographArray::tile_table();
  entries.store(std::as_bytes(std::span(preparation_->array().contents.tile_entries)));
  objects_.tile_entries = std::move(entries);
  if (objects_.mesh) make_vertices(*objects_.mesh);
  return Progress::whole;
}

}  // namespace lumatlas
