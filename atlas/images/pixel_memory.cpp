// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/pixel_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <limits>
#include <mutex>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace fs = std::filesystem;

namespace {

struct Bound {
  const PixelMemoryBound* owner;
  std::uint64_t bytes;
  fs::path folder;
};

// All that the buffers of a process share.
struct Memory {
  std::mutex mutex;
  std::vector<Bound> bounds;  // in the order of making
  std::vector<const ScratchFile*> files;
  PixelMemory used;
};

Memory& memory() {
  static Memory* const one = new Memory;  // never gone: buffers may outlive all other objects of the process
  return *one;
}

fs::path scratch_folder() {
  Memory& all = memory();
  const std::lock_guard lock(all.mutex);
  return all.bounds.empty() ? fs::temp_directory_path() : all.bounds.back().folder;
}

void add(const ScratchFile& file) {
  Memory& all = memory();
  const std::lock_guard lock(all.mutex);
  all.files.push_back(&file);
  all.used.in_files += file.size();
}

void remove(const ScratchFile& file) {
  Memory& all = memory();
  const std::lock_guard lock(all.mutex);
  std::erase(all.files, &file);
  all.used.in_files -= file.size();
}

// Returns the bytes of files in this process's memory; 0 where the system does not say.
std::uint64_t mapped_bytes_in_memory() {
  std::uint64_t pages = 0, resident = 0, shared = 0;
  std::ifstream file("/proc/self/statm");
  if (!(file >> pages >> resident >> shared)) return 0;
  return shared * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) (void)close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

// Opens a file without a name. Not each file system can make one at once; there the name is removed again.
int open_unnamed(const fs::path& folder) {
  const int unnamed = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (unnamed >= 0) return unnamed;
  std::string name = (folder / ".lumatlas-scratch-XXXXXX").string();
  const int named = mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) (void)unlink(name.c_str());
  return named;
}

// Returns whether the file took all bytes; if not, errno says why.
bool write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

[[noreturn]] void refuse(const fs::path& folder, std::size_t bytes) {
  const std::string reason = std::generic_category().message(errno);
  throw InputError(folder.string() + ": has no room for a scratch file of " + std::to_string(bytes) +
                   " bytes for what photographs need beyond the memory that they may take (" + reason +
                   "): make room there, name another folder by the environment variable TMPDIR, or allow more memory");
}

}  // namespace

PixelMemory pixel_memory() {
  Memory& all = memory();
  const std::lock_guard lock(all.mutex);
  return all.used;
}

PixelMemoryBound::PixelMemoryBound(std::uint64_t bytes, fs::path folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw InputError(folder.string() +
                     ": is no folder, so that it cannot take scratch files for photographs: name "
                     "another one by the environment variable TMPDIR");
  }
  Memory& all = memory();
  const std::lock_guard lock(all.mutex);
  all.bounds.push_back({this, bytes, std::move(folder)});
}

PixelMemoryBound::~PixelMemoryBound() {
  Memory& all = memory();
  const std::lock_guard lock(all.mutex);
  std::erase_if(all.bounds, [this](const Bound& bound) { return bound.owner == this; });
}

void give_back_scratch_pages() {
  Memory& all = memory();
  const std::lock_guard lock(all.mutex);
  if (all.bounds.empty() || all.files.empty() || mapped_bytes_in_memory() <= all.bounds.back().bytes / 2) return;
  for (const ScratchFile* file : all.files) file->give_back_pages();
}

std::uint64_t usual_pixel_memory() {
  constexpr std::uint64_t kLeast = std::uint64_t{256} << 20;
  std::ifstream file("/proc/meminfo");
  for (std::string name, unit; file >> name;) {
    std::uint64_t kibibytes = 0;
    if (name == "MemAvailable:" && file >> kibibytes) return std::max(kLeast, kibibytes * 1024 / 2);
    std::getline(file, unit);
  }
  return std::numeric_limits<std::uint64_t>::max();
}

bool PixelMemoryShare::take(std::size_t bytes) {
  Memory& all = memory();
  const std::lock_guard lock(all.mutex);
  if (!all.bounds.empty() && all.used.in_memory + bytes > all.bounds.back().bytes) return false;
  all.used.in_memory += bytes;
  return true;
}

PixelMemoryShare::PixelMemoryShare(std::size_t bytes) : bytes_(bytes) {}

PixelMemoryShare::PixelMemoryShare(PixelMemoryShare&& other) noexcept : bytes_(std::exchange(other.bytes_, 0)) {}

PixelMemoryShare& PixelMemoryShare::operator=(PixelMemoryShare&& other) noexcept {
  std::swap(bytes_, other.bytes_);
  return *this;
}

PixelMemoryShare::~PixelMemoryShare() {
  if (bytes_ == 0) return;
  Memory& all = memory();
  const std::lock_guard lock(all.mutex);
  all.used.in_memory -= bytes_;
}

ScratchFile::ScratchFile(std::span<const std::byte> bytes) : size_(bytes.size()) {
  const fs::path folder = scratch_folder();
  const Descriptor file(open_unnamed(folder));
  if (file.number() < 0 || !write_all(file.number(), bytes)) refuse(folder, size_);
  void* const mapped = mmap(nullptr, size_, PROT_READ, MAP_SHARED, file.number(), 0);
  if (mapped == MAP_FAILED) refuse(folder, size_);
  data_ = static_cast<const std::byte*>(mapped);
  add(*this);
  give_back_scratch_pages();
}

ScratchFile::~ScratchFile() {
  remove(*this);
  (void)munmap(const_cast<std::byte*>(data_), size_);
}

void ScratchFile::give_back_pages() const {
  (void)madvise(const_cast<std::byte*>(data_), size_, MADV_DONTNEED);
}

}  // namespace lumatlas
