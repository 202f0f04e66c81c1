// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/temporary_entry.h"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <deque>
#include <set>
#include <system_error>

#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using Kind = TemporaryEntry::Kind;

TEST_CASE("names are not told by the process or the order, and keep the ending") {
  std::set<std::string> names;
  std::set<char> first_digits;
  for (int i = 0; i < 200; ++i) {
    const std::string name = random_temporary_name(".png");
    REQUIRE(name.size() == 10 + 32 + 4);
    CHECK(name.starts_with(".lumatlas-"));
    CHECK(name.ends_with(".png"));
    names.insert(name);
    first_digits.insert(name[10]);
  }
  CHECK(names.size() == 200);
  CHECK(first_digits.size() > 8);  // of 16: 200 draws miss half of them once in 10^55
}

TEST_CASE("two processes that were one a moment ago, with the same memory, do not take the same names") {
  std::array<int, 2> ends{};
  REQUIRE(pipe(ends.data()) == 0);
  const pid_t child = fork();
  const std::string name = random_temporary_name();
  if (child == 0) _exit(write(ends[1], name.data(), name.size()) == static_cast<ssize_t>(name.size()) ? 0 : 1);
  std::string theirs(name.size(), '\0');
  REQUIRE(read(ends[0], theirs.data(), theirs.size()) == static_cast<ssize_t>(theirs.size()));
  REQUIRE(waitpid(child, nullptr, 0) == child);
  CHECK(theirs != name);
}

TEST_CASE("what exists under a name is never opened, another name is asked for") {
  for (const Kind kind : {Kind::file, Kind::folder}) {
    const TemporaryFolder folder;
    (void)folder.with_file("file", "precious");
    fs::create_directory(folder / "folder");
    (void)folder.with_file("folder/content", "precious");
    fs::create_symlink("nowhere", folder / "link");
    std::deque<std::string> names{"file", "folder", "link", "free"};
    {
      const TemporaryEntry entry(kind, folder.path(), [&] {
        const std::string name = names.front();
        names.pop_front();
        return name;
      });
      CHECK(entry.path() == folder / "free");
      CHECK(fs::is_directory(entry.path()) == (kind == Kind::folder));
      CHECK(fs::is_empty(entry.path()));
    }
    CHECK(bytes_of(folder / "file") == "precious");
    CHECK(bytes_of(folder / "folder/content") == "precious");
    CHECK(fs::is_symlink(folder / "link"));
    CHECK_FALSE(fs::exists(folder / "nowhere"));
    CHECK_FALSE(fs::exists(folder / "free"));
  }
}

TEST_CASE("names that are all taken, and folders that are not there, are errors") {
  const TemporaryFolder folder;
  (void)folder.with_file("taken", "precious");
  for (const Kind kind : {Kind::file, Kind::folder}) {
    CHECK_THROWS_AS(TemporaryEntry(kind, folder.path(), [] { return "taken"; }), std::system_error);
    CHECK_THROWS_AS(TemporaryEntry(kind, folder / "none", [] { return "name"; }), std::system_error);
  }
  CHECK(bytes_of(folder / "taken") == "precious");
}

TEST_CASE("what another process holds is no leftover until that is killed") {
  const TemporaryFolder folder;
  std::array<int, 2> ends{};
  REQUIRE(pipe(ends.data()) == 0);
  const pid_t child = fork();
  if (child == 0) {
    const TemporaryEntry a(Kind::folder, folder.path(), [] { return random_temporary_name(); });
    const TemporaryEntry b(Kind::file, folder.path(), [] { return random_temporary_name(".glb"); });
    if (write(ends[1], "x", 1) != 1) _exit(1);
    while (true) pause();
  }
  char made = 0;
  REQUIRE(read(ends[0], &made, 1) == 1);
  remove_leftovers(folder.path());
  CHECK(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()) == 2);
  kill(child, SIGKILL);
  REQUIRE(waitpid(child, nullptr, 0) == child);
  remove_leftovers(folder.path());
  CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("a process that ends without unwinding can remove what it has not released") {
  const TemporaryFolder folder;
  const pid_t child = fork();
  if (child == 0) {
    TemporaryEntry done(Kind::folder, folder.path(), [] { return "done"; });
    {
      const auto paused = removal_paused();
      done.release();
    }
    const TemporaryEntry half(Kind::folder, folder.path(), [] { return "half"; });
    std::ofstream(half.path() / "content") << "half";
    remove_temporary_entries();
    _exit(0);
  }
  REQUIRE(waitpid(child, nullptr, 0) == child);
  CHECK(fs::exists(folder / "done"));
  CHECK_FALSE(fs::exists(folder / "half"));
}

}  // namespace
}  // namespace lumatlas
