// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/snapshot_preparation.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <thread>
#include <utility>

#include "blend/tables/view_table.h"

namespace lumatlas {

namespace {

constexpr std::uint64_t kBytesAtOnce = 16 << 20;  // tiles that are prepared at once

template <typename T>
std::vector<std::byte> bytes_of(const std::vector<T>& values) {
  const auto bytes = std::as_bytes(std::span<const T>(values));
  return {bytes.begin(), bytes.end()};
}

// Returns what the former array holds.
ArrayContents known_contents(const FormerSnapshot& former) {
  ArrayContents contents = *former.array;
  for (const std::uint32_t place : former.unknown_places) contents.held[place] = {};
  return contents;
}

}  // namespace

SnapshotPreparation::SnapshotPreparation(Snapshot snapshot, FormerSnapshot former, const PreparationOptions& options)
    : snapshot_(std::move(snapshot)), former_(std::move(former)), options_(options) {}

void SnapshotPreparation::run() {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(begun_, true)) throw std::invalid_argument("next snapshot: it was prepared before");
    if (cancelled_) return;
  }
  try {
    check_after(former_.tables.get(), snapshot_);
    const ArrayContents former = known_contents(former_);
    array_ = next_array(former, snapshot_, options_.limits, options_.blocks);
    make_tables();
    {
      const std::lock_guard lock(mutex_);
      planned_ = true;
    }
    prepare_tiles(former);
    snapshot_ = {};
  } catch (...) {
    snapshot_ = {};
    const std::lock_guard lock(mutex_);
    error_ = std::current_exception();
    throw;
  }
}

void SnapshotPreparation::make_tables() {
  const SameTables same = same_tables(former_.tables.get(), snapshot_);
  tables_.tables = tables_after(former_.tables.get(), snapshot_);
  if (!move_mesh()) make_mesh(same);
  tables_.references = unranked(*tables_.lists);
  tables_.reference_bytes = bytes_of(tables_.references);
  tables_.views = view_table(snapshot_, array_.contents);
  if (tables_.views.size() > kBlockTexels) tables_.view_bytes = bytes_of(tables_.views);
}

// Makes positions alone, where only these have changed. Colours move with their vertices: those of the snapshot would
// take most of the time, because each photograph is projected anew. The snapshot after this one brings them.
bool SnapshotPreparation::move_mesh() {
  const Surface& surface = *tables_.tables->surface;
  if (!former_.zones || former_.zones->surface->mesh.positions == surface.mesh.positions) return false;
  if (former_.colors.size() != surface.mesh.positions.size()) return false;
  tables_.zones = moved_zones(tables_.tables->surface, options_.border_width, *former_.zones);
  if (!tables_.zones) return false;
  for (const DrawnBatch& batch : tables_.zones->batches) {
    tables_.positions.push_back(copied_positions(surface.mesh, batch));
  }
  auto tables = std::make_shared<SnapshotTables>(*tables_.tables);
  tables->vertex_colors = former_.colors;
  tables_.tables = std::move(tables);
  tables_.lists = lists_of(*tables_.tables, *tables_.zones);
  return true;
}

void SnapshotPreparation::make_mesh(const SameTables& same) {
  const SnapshotTables& tables = *tables_.tables;
  const DrawnZones* former = former_.zones.get();
  if (stays(former, same) && former->border_width == options_.border_width) {
    tables_.zones = former_.zones;
    const bool same_lists = former_.lists && same.references && same.deviation;
    tables_.lists = same_lists ? former_.lists : lists_of(tables, *tables_.zones);
  } else {
    MadeZones made = make_zones(tables, options_.border_width, options_.join_cells, former);
    tables_.mesh = std::move(made.mesh);
    tables_.zones = std::move(made.zones);
    tables_.lists = lists_of(tables, *tables_.zones);
  }
  std::span<const DrawnBatch> batches = tables_.zones->batches;
  if (tables_.mesh) {
    tables_.mesh->colors = copied_colors(tables.vertex_colors, batches.back());
    batches = batches.first(batches.size() - 1);
  }
  if (!(former_.colors == tables.vertex_colors)) {
    for (const DrawnBatch& batch : batches) tables_.colors.push_back(copied_colors(tables.vertex_colors, batch));
  }
}

// Makes tiles on all processors, kBytesAtOnce of them at a time.
void SnapshotPreparation::prepare_tiles(const ArrayContents& former) {
  const ArrayShape& shape = array_.contents.shape;
  const std::size_t at_once = std::max<std::size_t>(
      std::min(kBytesAtOnce, options_.waiting_bytes) / (4 * std::size_t{shape.place_width} * shape.place_height), 1);
  std::vector<char> is_copied(array_.missing.size());
  for (std::size_t first = 0; first < array_.missing.size(); first += at_once) {
    if (!wait_for_room()) return;
    const std::size_t end = std::min(first + at_once, array_.missing.size());
    tbb::parallel_for(first, end, [&](std::size_t i) {
      const StoredView& view = *snapshot_.views[array_.missing[i].upload.view];
      is_copied[i] = prepare_missing(array_, i, former, view) ? 1 : 0;
    });
    const std::lock_guard lock(mutex_);
    for (std::size_t i = first; i < end; ++i) {
      if (is_copied[i] == 0) continue;
      if (cancelled_) return;
      waiting_ += array_.missing[i].upload.bytes();
      ready_.push_back(std::move(array_.missing[i].upload));
    }
  }
  tables_.tile_entry_bytes = bytes_of(array_.contents.tile_entries);
  const std::lock_guard lock(mutex_);
  finished_ = true;
}

bool SnapshotPreparation::wait_for_room() {
  std::unique_lock lock(mutex_);
  const auto has_room = [&] { return cancelled_ || waiting_ == 0 || waiting_ < options_.waiting_bytes; };
  if (!has_room() && std::this_thread::get_id() == options_.uploading_thread) {
    throw std::logic_error(
        "next snapshot: prepare() waits for upload() of its own thread: prepare it on another, or allow more "
        "waiting_bytes");
  }
  changed_.wait(lock, has_room);
  return !cancelled_;
}

void SnapshotPreparation::cancel() {
  const std::lock_guard lock(mutex_);
  cancelled_ = true;
  for (const TileUpload& tile : ready_) waiting_ -= tile.bytes();
  ready_.clear();
  changed_.notify_all();
}

bool SnapshotPreparation::is_cancelled() const {
  const std::lock_guard lock(mutex_);
  return cancelled_;
}

std::uint64_t SnapshotPreparation::waiting_bytes() const {
  const std::lock_guard lock(mutex_);
  return waiting_;
}

void SnapshotPreparation::throw_error() const {
  if (error_) std::rethrow_exception(error_);
}

bool SnapshotPreparation::is_planned() {
  const std::lock_guard lock(mutex_);
  throw_error();
  return planned_;
}

std::optional<TileUpload> SnapshotPreparation::next_tile() {
  const std::lock_guard lock(mutex_);
  throw_error();
  if (ready_.empty()) return std::nullopt;
  TileUpload tile = std::move(ready_.front());
  ready_.pop_front();
  return tile;
}

void SnapshotPreparation::give_back(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  waiting_ -= bytes;
  changed_.notify_all();
}

bool SnapshotPreparation::is_whole() {
  const std::lock_guard lock(mutex_);
  throw_error();
  return !cancelled_ && finished_ && ready_.empty() && waiting_ == 0;
}

}  // namespace lumatlas
