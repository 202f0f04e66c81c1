// SPDX-License-Identifier: GPL-3.0-or-later
// Files and folders that exist only while an output is being written: named so that no other process, container or
// machine takes the same name, locked while their process lives, and removed when it stops.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <string>

namespace lumatlas {

// ".lumatlas-", 128 random bits of the system as 32 hexadecimal digits, and `ending`.
[[nodiscard]] std::string random_temporary_name(const std::string& ending = "");

// A new empty file or folder that no other process uses. The destructor and remove_temporary_entries() remove it with
// its contents. Its lock (flock) ends with the process, however that ends, and tells remove_leftovers() of later
// processes that it is abandoned.
class TemporaryEntry {
 public:
  enum class Kind { file, folder };
  using Names = std::function<std::string()>;

  // In `folder`. A name that exists is never opened: another one is asked for. Throws std::system_error.
  // `names` is asked up to a hundred times.
  TemporaryEntry(Kind kind, const std::filesystem::path& folder, const Names& names);
  ~TemporaryEntry();
  TemporaryEntry(const TemporaryEntry&) = delete;
  TemporaryEntry& operator=(const TemporaryEntry&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  // Makes the entry permanent, or gives up one that was moved away: nothing removes it any more. Call it, like every
  // rename from or to path(), while removal_paused() is held.
  void release();

 private:
  bool make(Kind kind);
  void remove();

  std::filesystem::path path_;
  int lock_ = -1;
  bool released_ = false;
};

// While this is held, remove_temporary_entries() waits.
[[nodiscard]] std::unique_lock<std::mutex> removal_paused();

// Removes every temporary entry of this process, for a process that is about to end without unwinding, and lets no
// thread make another one: threads that try wait without end. From any thread, never throws.
void remove_temporary_entries() noexcept;

// Removes from `folder` the temporary entries that a process left behind which was killed at once. Leaves alone entries
// that a living process has locked, entries of another name, and everything on network file systems, where locks may
// not work. Never throws: leftovers that cannot be removed stay.
void remove_leftovers(const std::filesystem::path& folder) noexcept;

// Waits until the disk has the file, or the names in the folder. False, with errno, where they could not be written;
// some file systems cannot be asked, and do without.
[[nodiscard]] bool sync_to_disk(const std::filesystem::path& path);
// The same for everything on the file system of `folder`, in one piece: for folders of many files.
[[nodiscard]] bool sync_file_system(const std::filesystem::path& folder);

// Locks the file or folder at a path as a process locks its temporary entries; a rename keeps the lock. Does nothing if
// it cannot be locked.
class LeftoverLock {
 public:
  explicit LeftoverLock(const std::filesystem::path& path);
  ~LeftoverLock();
  LeftoverLock(const LeftoverLock&) = delete;
  LeftoverLock& operator=(const LeftoverLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace lumatlas
