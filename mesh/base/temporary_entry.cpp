// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/temporary_entry.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <set>
#include <string_view>
#include <system_error>
#include <vector>

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = ".lumatlas-";
constexpr std::size_t kRandomBytes = 16;
constexpr std::string_view kDigits = "0123456789abcdef";

std::mutex entries_mutex;
std::set<fs::path>& entries() {                       // guarded by entries_mutex
  static auto* const paths = new std::set<fs::path>;  // never destroyed: threads may outlive main()
  return *paths;
}

[[noreturn]] void throw_errno(const fs::path& path) {
  throw std::system_error(errno, std::generic_category(), path.string());
}

bool is_temporary_name(std::string_view name) {
  if (!name.starts_with(kPrefix)) return false;
  name.remove_prefix(kPrefix.size());
  const std::string_view digits = name.substr(0, 2 * kRandomBytes);
  const std::string_view ending = name.substr(digits.size());
  return digits.size() == 2 * kRandomBytes && digits.find_first_not_of(kDigits) == std::string_view::npos &&
         (ending.empty() || ending.starts_with('.'));
}

// NFS, CIFS, SMB2, 9P and FUSE: a lock that a process of another machine holds may not be seen from here.
bool is_on_network(const fs::path& folder) {
  constexpr std::array<std::uint32_t, 5> kTypes{0x6969, 0xff534d42, 0xfe534d42, 0x01021997, 0x65735546};
  struct statfs info {};
  if (statfs(folder.c_str(), &info) != 0) return true;
  return std::find(kTypes.begin(), kTypes.end(), static_cast<std::uint32_t>(info.f_type)) != kTypes.end();
}

bool is_still_at(const fs::path& path, int descriptor) {
  struct stat opened {
  }, named{};
  return fstat(descriptor, &opened) == 0 && lstat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

// Without following a link or waiting for the other end of a pipe; -1 with errno: it cannot be opened.
int open_quietly(const fs::path& path) {
  return open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
}

bool synced(const fs::path& path, int (*sync)(int)) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return errno == EACCES;  // a folder that may be written to but not read
  const bool is_synced = sync(descriptor) == 0 || errno == EINVAL || errno == ENOSYS;
  const int error = errno;
  close(descriptor);
  errno = error;
  return is_synced;
}

void remove_leftover(const fs::path& path) {
  const int descriptor = open_quietly(path);
  if (descriptor < 0) return;
  std::error_code ignored;
  if (flock(descriptor, LOCK_EX | LOCK_NB) == 0 && is_still_at(path, descriptor)) fs::remove_all(path, ignored);
  close(descriptor);
}

}  // namespace

std::string random_temporary_name(const std::string& ending) {
  std::array<unsigned char, kRandomBytes> bytes{};
  for (std::size_t have = 0; have < bytes.size();) {
    const ssize_t more = getrandom(bytes.data() + have, bytes.size() - have, 0);
    if (more < 0 && errno != EINTR) throw_errno("getrandom");
    have += more > 0 ? static_cast<std::size_t>(more) : 0;
  }
  std::string name(kPrefix);
  for (const unsigned char byte : bytes) name.append({kDigits[byte / 16], kDigits[byte % 16]});
  return name + ending;
}

TemporaryEntry::TemporaryEntry(Kind kind, const fs::path& folder, const Names& names) {
  constexpr int kAttempts = 100;  // one is enough, unless something is badly wrong with the folder or the names
  const auto lock = removal_paused();
  for (int attempt = 1; path_ = folder / names(), !make(kind); ++attempt) {
    if (attempt == kAttempts) throw std::system_error(EEXIST, std::generic_category(), path_.string());
  }
  entries().insert(path_);
}

// False: the name is taken, or remove_leftovers() of another process was faster than our lock.
bool TemporaryEntry::make(Kind kind) {
  if (kind == Kind::file) {
    lock_ = open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (lock_ < 0 && errno == EEXIST) return false;
    if (lock_ < 0) throw_errno(path_);
  } else {
    if (mkdir(path_.c_str(), 0777) != 0) {
      if (errno == EEXIST) return false;
      throw_errno(path_);
    }
    lock_ = open_quietly(path_);
    if (lock_ < 0 && errno == ENOENT) return false;
    if (lock_ < 0) {
      const int error = errno;
      rmdir(path_.c_str());
      throw std::system_error(error, std::generic_category(), path_.string());
    }
  }
  const bool is_taken = flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  if (!is_taken && is_still_at(path_, lock_)) return true;
  close(lock_);
  lock_ = -1;
  return false;
}

TemporaryEntry::~TemporaryEntry() {
  if (!released_) remove();
  const auto lock = removal_paused();
  entries().erase(path_);
  close(lock_);
}

void TemporaryEntry::remove() {
  std::error_code ignored;  // a destructor cannot report it; the next run tries again
  fs::remove_all(path_, ignored);
}

void TemporaryEntry::release() {
  released_ = true;
  entries().erase(path_);
}

std::unique_lock<std::mutex> removal_paused() {
  return std::unique_lock(entries_mutex);
}

void remove_temporary_entries() noexcept {
  constexpr int kAttempts = 100;  // other threads may go on writing into a folder that is being removed
  try {
    entries_mutex.lock();  // and never unlocks it
    for (const fs::path& path : entries()) {
      std::error_code error;
      for (int i = 0; i < kAttempts; ++i) {
        fs::remove_all(path, error);
        if (!error && fs::symlink_status(path, error).type() == fs::file_type::not_found) break;
      }
    }
  } catch (...) {  // NOLINT(bugprone-empty-catch): what stays is removed by a later run
  }
}

void remove_leftovers(const fs::path& folder) noexcept {
  try {
    if (is_on_network(folder)) return;
    std::error_code error;
    std::vector<fs::path> found;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
      if (is_temporary_name(entry->path().filename().native())) found.push_back(entry->path());
    }
    for (const fs::path& path : found) remove_leftover(path);
  } catch (...) {  // NOLINT(bugprone-empty-catch): leftovers are no reason to fail
  }
}

bool sync_to_disk(const fs::path& path) {
  return synced(path, fsync);
}

bool sync_file_system(const fs::path& folder) {
  return synced(folder, syncfs);
}

LeftoverLock::LeftoverLock(const fs::path& path) : descriptor_(open_quietly(path)) {
  if (descriptor_ >= 0) (void)flock(descriptor_, LOCK_EX | LOCK_NB);
}

LeftoverLock::~LeftoverLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace lumatlas
