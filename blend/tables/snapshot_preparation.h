// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the half of a snapshot's way to the GPU that needs no OpenGL, on a thread of its own. The other
// half is gl/snapshot_upload.h.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "atlas/snapshot.h"
#include "blend/tables/array_contents.h"
#include "blend/tables/snapshot_tables.h"

namespace lumatlas {

// What a renderer draws when the next snapshot is begun. Pointers are null before its first snapshot or picture.
struct FormerSnapshot {
  std::shared_ptr<const SnapshotTables> tables;
  std::shared_ptr<const DrawnZones> zones;
  std::shared_ptr<const ZoneReferences> lists;
  FallbackColors colors;                       // of the mesh
  std::shared_ptr<const ArrayContents> array;  // never null
  std::set<std::uint32_t> unknown_places;  // of the array, where an earlier snapshot was given up: they hold nothing
};

struct PreparationOptions {
  double border_width = 0;  // of BlendOptions
  bool join_cells = true;
  bool blocks = true;
  ArrayLimits limits;
  std::uint64_t waiting_bytes = 0;  // texels that may wait; one piece may in any case
  std::thread::id uploading_thread;
};

// All but the photographs.
struct PreparedTables {
  std::shared_ptr<const SnapshotTables> tables;
  std::shared_ptr<const DrawnZones> zones;
  std::optional<ZoneMesh> mesh;  // of the last batch; none: no batch is new
  // For each batch that stays, in their order. Empty: their positions, or their colours, stay too.
  std::vector<std::vector<glm::vec3>> positions;
  std::vector<std::vector<glm::u8vec3>> colors;
  std::shared_ptr<const ZoneReferences> lists;
  std::vector<RankedReference> references;  // not ranked yet
  std::vector<glm::vec4> views;
  // Bytes of `references`, of `views` and of the tiles' places, which a GlTable keeps. Those of the places are there
  // once all tiles are prepared.
  std::vector<std::byte> reference_bytes, view_bytes, tile_entry_bytes;
};

class SnapshotPreparation {
 public:
  SnapshotPreparation(Snapshot snapshot, FormerSnapshot former, const PreparationOptions& options);

  // NextSnapshot::prepare(), and NextSnapshot's functions of these names, call them.
  void run();
  void cancel();
  [[nodiscard]] bool is_cancelled() const;
  [[nodiscard]] std::uint64_t waiting_bytes() const;

  // For the thread that uploads. All but give_back() throw what run() has thrown.
  // Returns whether tables() and array() may be read, except the contents' held tiles and the values of their entries.
  [[nodiscard]] bool is_planned();
  // Returns the next tile that is prepared, or none if none waits now. Its bytes wait until they are given back.
  [[nodiscard]] std::optional<TileUpload> next_tile();
  void give_back(std::uint64_t bytes);
  // Returns whether all tiles were prepared and taken: array() may be read as a whole. Never true once the snapshot was
  // given up, which throws tiles away.
  [[nodiscard]] bool is_whole();

  [[nodiscard]] const FormerSnapshot& former() const { return former_; }
  [[nodiscard]] PreparedTables& tables() { return tables_; }
  [[nodiscard]] NextArray& array() { return array_; }

  // All that is left of a snapshot, and of the former one, once is_whole() has returned true.
  struct Rest {
    FormerSnapshot former;
    PreparedTables tables;
    NextArray array;
  };
  [[nodiscard]] Rest take_rest() { return {std::move(former_), std::move(tables_), std::move(array_)}; }

 private:
  void make_tables();
  void make_mesh(const SameTables& same);
  [[nodiscard]] bool move_mesh();
  void prepare_tiles(const ArrayContents& former);
  // Waits until more tiles may wait. Returns false if the snapshot was given up.
  [[nodiscard]] bool wait_for_room();
  void throw_error() const;

  Snapshot snapshot_;
  FormerSnapshot former_;
  PreparationOptions options_;
  PreparedTables tables_;
  NextArray array_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // Guarded by the mutex.
  std::deque<TileUpload> ready_;
  std::uint64_t waiting_ = 0;
  bool begun_ = false, planned_ = false, finished_ = false, cancelled_ = false;
  std::exception_ptr error_;
};

}  // namespace lumatlas
