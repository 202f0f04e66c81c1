// SPDX-License-Identifier: GPL-3.0-or-later
// A file that appears under its name only when it is complete: readers see the old file or the new one, never half of
// it.
#pragma once

#include <filesystem>
#include <memory>

#include "mesh/base/temporary_entry.h"

namespace lumatlas {

// Selects whether commit() waits until the file is on disk. Thousands of files in one folder can leave the waiting to
// the code that puts their folder in place.
enum class Durability { on_disk, left_to_folder };

// Write to path(), then commit(). Without commit() nothing is left behind and the target is as it was.
class PendingFile {
 public:
  // Makes an empty file at path(). Throws InputError if the target's folder does not exist or cannot be written to.
  explicit PendingFile(std::filesystem::path target);
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  // Beside the target, with the target's ending; different for every object of every process, see temporary_entry.h.
  [[nodiscard]] const std::filesystem::path& path() const { return temporary_->path(); }

  // Renames path() to the target, which may exist. Throws InputError naming the target.
  void commit(Durability durability = Durability::on_disk);

 private:
  std::filesystem::path target_;
  std::unique_ptr<TemporaryEntry> temporary_;
};

}  // namespace lumatlas
