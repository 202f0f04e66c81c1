// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/files_below.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

TEST_CASE("files below a folder are listed by name, through links to files and folders") {
  const TemporaryFolder folder, elsewhere;
  fs::create_directories(folder / "root" / "a");
  fs::create_directory(elsewhere / "card");
  (void)folder.with_file("root/b.jpg", "b");
  (void)folder.with_file("root/a/c.jpg", "c");
  (void)elsewhere.with_file("card/d.jpg", "d");
  (void)elsewhere.with_file("e.jpg", "e");
  fs::create_directory_symlink(elsewhere / "card", folder / "root" / "card1");
  fs::create_symlink(elsewhere / "e.jpg", folder / "root" / "e.jpg");
  fs::create_symlink(elsewhere / "missing.jpg", folder / "root" / "gone.jpg");
  const FilesBelow found = files_below(folder / "root");
  CHECK_FALSE(found.error);
  CHECK(found.names == Names{"a/c.jpg", "b.jpg", "card1/d.jpg", "e.jpg"});
  const auto is_card = [](const fs::path& path) { return path.filename() == "card1"; };
  CHECK(files_below(folder / "root", is_card).names == Names{"a/c.jpg", "b.jpg", "e.jpg"});
  // The folder itself may be a link.
  fs::create_directory_symlink(folder / "root", elsewhere / "root");
  CHECK(files_below(elsewhere / "root").names == found.names);
}

TEST_CASE("links that lead in circles, or to a folder twice, list each folder once and by its own name first") {
  const TemporaryFolder folder;
  fs::create_directories(folder / "root" / "z");
  (void)folder.with_file("root/z/f.jpg", "f");
  fs::create_directory_symlink(folder / "root" / "z", folder / "root" / "a-link");
  fs::create_directory_symlink("..", folder / "root" / "z" / "up");
  fs::create_directory_symlink("/", folder / "root" / "everything");
  CHECK(files_below(folder / "root").names == Names{"z/f.jpg"});
}

TEST_CASE("a folder that is not there lists nothing, and says so") {
  const FilesBelow found = files_below("/no/such/folder");
  CHECK(found.names.empty());
  CHECK(found.error == std::errc::no_such_file_or_directory);
}

}  // namespace
}  // namespace lumatlas
