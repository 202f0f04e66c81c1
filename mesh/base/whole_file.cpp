// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

std::string last_error() {
  return std::error_code(errno, std::generic_category()).message();
}

class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return value_; }
  // Some file systems tell only now that a write has failed.
  [[nodiscard]] bool closed() { return close(std::exchange(value_, -1)) == 0; }

 private:
  int value_;
};

bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

// Returns the number of bytes read, at most the string's; -1 with errno.
ssize_t read_all(int file, std::string& bytes) {
  std::size_t have = 0;
  while (have < bytes.size()) {
    const ssize_t more = read(file, bytes.data() + have, bytes.size() - have);
    if (more < 0 && errno == EINTR) continue;
    if (more < 0) return -1;
    if (more == 0) break;
    have += static_cast<std::size_t>(more);
  }
  return static_cast<ssize_t>(have);
}

}  // namespace

std::string read_whole_file(const std::filesystem::path& path) {
  const auto fail = [&](const std::string& reason) { throw InputError(path.string() + ": " + reason); };
  // Without O_NONBLOCK, opening a pipe would wait for its other end.
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) {
    if (errno == ENOENT || errno == ENOTDIR) fail("no such file");
    fail(errno == ENXIO ? "is not a file" : "cannot be opened; check that it may be read (" + last_error() + ")");
  }
  struct stat status {};
  if (fstat(file.get(), &status) != 0) fail("cannot be examined (" + last_error() + ")");
  if (!S_ISREG(status.st_mode)) fail("is not a file");
  if (status.st_size == 0) fail("is empty");
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  const ssize_t read = read_all(file.get(), bytes);
  if (read < 0) fail("cannot be read to its end (" + last_error() + ")");
  if (static_cast<std::size_t>(read) != bytes.size()) {
    fail("cannot be read to its end: it was shortened from " + std::to_string(bytes.size()) + " to " +
         std::to_string(read) + " bytes meanwhile");
  }
  return bytes;
}

void write_whole_file(const std::filesystem::path& path, std::string_view bytes, Durability durability) {
  PendingFile pending(path);
  Descriptor file(open(pending.path().c_str(), O_WRONLY | O_CLOEXEC));
  if (file.get() < 0 || !write_all(file.get(), bytes) || !file.closed()) {
    throw InputError(path.string() + ": cannot be written (" + last_error() +
                     "): check the folder's permissions and the disk's free space");
  }
  pending.commit(durability);
}

}  // namespace lumatlas
