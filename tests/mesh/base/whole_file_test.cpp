// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/whole_file.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <string>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

TEST_CASE("a file is read as it was written, and what happens to it later does not reach the bytes") {
  const TemporaryFolder folder;
  const std::string bytes("a\0\r\n\xff", 5);
  write_whole_file(folder / "a", bytes);
  const std::string read = read_whole_file(folder / "a");
  fs::resize_file(folder / "a", 1);
  CHECK(read == bytes);
}

TEST_CASE("what is no file, or an empty one, is refused by name") {
  const TemporaryFolder folder;
  const auto refused = [](const fs::path& path, const std::string& reason) {
    CHECK_THROWS_WITH(read_whole_file(path), path.string() + ": " + reason);
  };
  refused(folder / "none", "no such file");
  refused(folder.with_file("empty", "") / "none", "no such file");
  refused(folder / "empty", "is empty");
  refused(folder.path(), "is not a file");
  refused("/dev/null", "is not a file");
  REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
  refused(folder / "pipe", "is not a file");
}

TEST_CASE("a write that fails half way is told, with the reason, and leaves the earlier file") {
  const TemporaryFolder folder;
  const fs::path target = folder.with_file("a", "old");
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      write_whole_file(target, std::string(5000, 'x'));
    } catch (const InputError& error) {
      const std::string sentence = target.string() + ": cannot be written (File too large)";
      _exit(std::string(error.what()).starts_with(sentence) ? 7 : 1);
    }
    _exit(0);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 7));
  CHECK(bytes_of(target) == "old");
  CHECK(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()) == 1);
}

}  // namespace
}  // namespace lumatlas
