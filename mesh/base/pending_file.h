// SPDX-License-Identifier: GPL-3.0-or-later
// A file that appears under its name only when it is complete: readers see the old file or the new one, never half of
// it.
#pragma once

#include <filesystem>

namespace lumatlas {

// Write to path(), then commit(). Without commit() nothing is left behind and the target is as it was.
class PendingFile {
 public:
  // Nothing is created yet. Throws InputError if the target's folder does not exist.
  explicit PendingFile(std::filesystem::path target);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  // Beside the target, with the target's ending; different for every object of every process.
  [[nodiscard]] const std::filesystem::path& path() const { return temporary_; }

  // Renames path() to the target, which may exist. Throws InputError naming the target.
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
};

}  // namespace lumatlas
