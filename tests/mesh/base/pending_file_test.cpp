// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/pending_file.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

TEST_CASE("a pending file takes its place at commit, or leaves nothing") {
  const TemporaryFolder folder;
  const fs::path target = folder.with_file("a.png", "old");
  for (const Durability durability : {Durability::on_disk, Durability::left_to_folder}) {
    {
      const PendingFile pending(target);
      CHECK(pending.path().parent_path() == folder.path());
      CHECK(pending.path().extension() == ".png");
      std::ofstream(pending.path()) << "half";
    }
    CHECK(bytes_of(target) == "old");
    PendingFile pending(target);
    std::ofstream(pending.path()) << "new";
    pending.commit(durability);
    CHECK(bytes_of(target) == "new");
    CHECK(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()) == 1);
    (void)folder.with_file("a.png", "old");
  }
}

TEST_CASE("a name may be as long as the file system allows") {
  const TemporaryFolder folder;
  for (const std::string& name : {std::string(251, 'a').append(".png"), std::string("a.").append(253, 'p')}) {
    PendingFile pending(folder / name);
    std::ofstream(pending.path()) << "new";
    pending.commit();
    CHECK(bytes_of(folder / name) == "new");
  }
}

TEST_CASE("a folder may be a link, and have no name but a dot") {
  const TemporaryFolder folder;
  fs::create_directory(folder / "real");
  fs::create_directory_symlink("real", folder / "link");
  PendingFile pending(folder / "link/a");
  std::ofstream(pending.path()) << "new";
  pending.commit();
  CHECK(bytes_of(folder / "real/a") == "new");
  const fs::path before = fs::current_path();
  fs::current_path(folder.path());
  PendingFile here("b");
  here.commit();
  CHECK(fs::exists(folder / "b"));
  fs::current_path(before);
}

TEST_CASE("a pending file without its folder, and a folder in its place, are refused by name") {
  const TemporaryFolder folder;
  const std::string missing = (folder / "none/a.png").string();
  CHECK_THROWS_WITH(PendingFile(missing), missing + ": cannot be written, its folder does not exist");
  fs::create_directories(folder / "b/c");
  PendingFile pending(folder / "b");
  CHECK_THROWS_AS(pending.commit(), InputError);
  CHECK(fs::exists(folder / "b/c"));
}

}  // namespace
}  // namespace lumatlas
