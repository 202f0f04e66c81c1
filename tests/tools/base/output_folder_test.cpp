// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/output_folder.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "mesh/base/errors.h"
#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

std::ptrdiff_t entries(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

void make_output(const fs::path& path, const std::string& content) {
  OutputFolder out(path, "build");
  write_text(out.path() / "content", content);
  out.commit({{"content", content}});
}

const std::string kNotOurs =
    ": is not an earlier output of lumatlas (it has no lumatlas.json that lists its files) and will not be replaced, "
    "name another folder or remove it";

TEST_CASE("a committed folder is in place with its marker and options, and nothing else is left") {
  const TemporaryFolder folder;
  OutputFolder out(folder.path() / "out", "build");
  write_text(out.path() / "content", "new");
  CHECK_FALSE(fs::exists(folder.path() / "out"));
  out.commit({{"hold", 8}});
  CHECK(out.path() == folder.path() / "out");
  CHECK(bytes_of(out.path() / "content") == "new");
  const auto marker = nlohmann::json::parse(bytes_of(out.path() / "lumatlas.json"));
  CHECK(marker["options"]["hold"] == 8);
  CHECK(marker["lumatlas"].is_string());
  CHECK(entries(folder.path()) == 1);
}

TEST_CASE("a folder that is not committed vanishes with the parents that were made for it") {
  const TemporaryFolder folder;
  {
    const OutputFolder out(folder.path() / "a" / "b" / "out", "build");
    write_text(out.path() / "content", "half");
    CHECK(entries(folder.path() / "a" / "b") == 1);
  }
  CHECK(entries(folder.path()) == 0);
}

TEST_CASE("an earlier output stays until commit and is replaced as a whole") {
  const TemporaryFolder folder;
  const fs::path target = folder.path() / "out";
  {
    OutputFolder old(target, "build");
    write_text(old.path() / "content", "old");
    write_text(old.path() / "only in the old one", "");
    old.commit({});
  }
  {
    const OutputFolder abandoned(target, "build");
    write_text(abandoned.path() / "content", "half");
  }
  CHECK(bytes_of(target / "content") == "old");
  make_output(target, "new");
  CHECK(bytes_of(target / "content") == "new");
  CHECK_FALSE(fs::exists(target / "only in the old one"));
  CHECK(entries(folder.path()) == 1);
}

TEST_CASE("an empty folder is replaced") {
  const TemporaryFolder folder;
  fs::create_directory(folder.path() / "out");
  make_output(folder.path() / "out", "new");
  CHECK(bytes_of(folder.path() / "out" / "content") == "new");
}

TEST_CASE("a folder that lumatlas did not write is refused at once and left alone") {
  const TemporaryFolder folder;
  const fs::path target = folder.path() / "photographs";
  fs::create_directory(target);
  write_text(target / "DSC_0001.jpg", "precious");
  CHECK_THROWS_WITH(OutputFolder(target, "build"), target.string() + kNotOurs);
  for (const std::string marker : {"", "[]", "{}", "{\"lumatlas\"", "{\"mesh\": \"lumatlas\"}"}) {
    write_text(target / "lumatlas.json", marker);
    CHECK_THROWS_WITH(OutputFolder(target, "build"), target.string() + kNotOurs);
  }
  CHECK(bytes_of(target / "DSC_0001.jpg") == "precious");
  CHECK(entries(folder.path()) == 1);
}

// A folder as `lumatlas build` leaves it, with a report that `lumatlas validate` put into it.
void make_model_with_report(const fs::path& target) {
  make_output(target, "old");
  OutputFolder report(target / "report", "validate");
  fs::create_directory(report.path() / "pictures");
  write_text(report.path() / "pictures" / "a.png", "picture");
  report.commit({});
}

TEST_CASE("a model's own report goes with it, a person's notes in either keep both") {
  const TemporaryFolder folder;
  const fs::path target = folder.path() / "out";
  for (const std::string notes : {"notes.txt", "images/notes.txt", "report/notes.txt", "report/pictures/b.png"}) {
    CAPTURE(notes);
    make_model_with_report(target);
    fs::create_directories((target / notes).parent_path());
    write_text(target / notes, "precious");
    CHECK_THROWS_WITH(OutputFolder(target, "build"), target.string() +
                                                         ": will not be replaced, because lumatlas did not write " +
                                                         notes + " in it: move that elsewhere, or name another folder");
    CHECK(bytes_of(target / "content") == "old");
    fs::remove(target / notes);
    make_output(target, "new");
    CHECK(bytes_of(target / "content") == "new");
    CHECK_FALSE(fs::exists(target / "report"));
  }
  fs::create_symlink("content", target / "link");
  CHECK_THROWS_WITH(OutputFolder(target, "build"), Catch::Contains("did not write link in it"));
}

TEST_CASE("notes that are written beside an output while the next one is made keep it") {
  const TemporaryFolder folder;
  const fs::path target = folder.path() / "out";
  make_output(target, "old");
  OutputFolder out(target, "build");
  write_text(target / "notes.txt", "precious");
  CHECK_THROWS_WITH(out.commit({}), Catch::Contains("did not write notes.txt in it"));
  CHECK(bytes_of(target / "notes.txt") == "precious");
  CHECK(bytes_of(target / "content") == "old");
}

TEST_CASE("an output of another command is refused") {
  const TemporaryFolder folder;
  const fs::path target = folder.path() / "out";
  make_output(target, "model");
  CHECK_THROWS_WITH(OutputFolder(target, "synth"),
                    target.string() + ": is an output of `lumatlas build` and will not be replaced by one of " +
                        "`lumatlas synth`, name another folder or remove it");
  CHECK_THROWS_AS(OutputFolder(target, "validate"), InputError);
  CHECK(bytes_of(target / "content") == "model");
}

TEST_CASE("files whose names are not UTF-8 are known again") {
  const TemporaryFolder folder;
  {
    OutputFolder out(folder.path() / "out", "build");
    write_text(out.path() / "caf\xe9.png", "picture");
    out.commit({});
  }
  CHECK_NOTHROW(check_replaceable(folder.path() / "out", "build"));
}

TEST_CASE("what a killed process left behind is removed by the next output beside it, what a living one holds stays") {
  const TemporaryFolder folder;
  const fs::path dead = folder.path() / random_temporary_name(),
                 dead_file = folder.path() / random_temporary_name(".png");
  const fs::path other = folder.path() / ".lumatlas-mine";
  for (const fs::path& path : {dead, other}) {
    fs::create_directory(path);
    write_text(path / "content", "half");
  }
  write_text(dead_file, "half");
  fs::create_directory_symlink(other, folder.path() / random_temporary_name());  // not ours: we make no links
  const OutputFolder living(folder.path() / "living", "build");
  write_text(living.path() / "content", "half");
  make_output(folder.path() / "out", "new");
  CHECK_FALSE(fs::exists(dead));
  CHECK_FALSE(fs::exists(dead_file));
  CHECK(bytes_of(living.path() / "content") == "half");
  CHECK(bytes_of(other / "content") == "half");
  CHECK(entries(folder.path()) == 4);
  write_text(dead_file, "half");
  write_json(folder / "a.json", {});
  CHECK_FALSE(fs::exists(dead_file));
}

TEST_CASE("a folder that another process fills meanwhile is refused at commit") {
  const TemporaryFolder folder;
  const fs::path target = folder.path() / "out";
  {
    OutputFolder out(target, "build");
    fs::create_directory(target);
    write_text(target / "theirs", "precious");
    CHECK_THROWS_WITH(out.commit({}), target.string() + kNotOurs);
  }
  CHECK(bytes_of(target / "theirs") == "precious");
  CHECK(entries(folder.path()) == 1);
}

TEST_CASE("a file in the folder's place or in its parent's is refused") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "out";
  write_text(file, "precious");
  CHECK_THROWS_WITH(OutputFolder(file, "build"), file.string() + ": is not a folder, name another output");
  CHECK_THROWS_AS(OutputFolder(file / "below", "build"), InputError);
  CHECK(bytes_of(file) == "precious");
}

TEST_CASE("an output path that is empty or the root is refused") {
  CHECK_THROWS_WITH(OutputFolder("", "build"), "the output path is empty, name a file or folder");
  CHECK_THROWS_WITH(OutputFolder("/", "build"), "/" + kNotOurs);
}

TEST_CASE("a trailing slash and a link to an earlier output mean the folder itself") {
  const TemporaryFolder folder;
  make_output(folder.path() / "out/", "one");
  CHECK(bytes_of(folder.path() / "out" / "content") == "one");
  fs::create_directory_symlink("out", folder.path() / "latest");
  make_output(folder.path() / "latest", "two");
  CHECK(fs::is_symlink(folder.path() / "latest"));
  CHECK(bytes_of(folder.path() / "out" / "content") == "two");
}

TEST_CASE("options with bytes that are not UTF-8 do not cost the output") {
  const TemporaryFolder folder;
  OutputFolder out(folder.path() / "out", "build");
  out.commit({{"mesh", "caf\xe9.ply"}});
  CHECK_NOTHROW(check_replaceable(folder.path() / "out", "build"));
}

TEST_CASE("a folder is committed only once") {
  const TemporaryFolder folder;
  OutputFolder out(folder.path() / "out", "build");
  out.commit({});
  CHECK_THROWS_AS(out.commit({}), std::invalid_argument);
}

TEST_CASE("both ways to swap folders swap them, and renaming undoes itself if it fails") {
  const TemporaryFolder folder;
  const fs::path a = folder.path() / "a";
  const fs::path b = folder.path() / "b";
  make_output(a, "a");
  make_output(b, "b");
  swap_folders_by_renaming(a, b);
  CHECK(bytes_of(a / "content") == "b");
  CHECK(bytes_of(b / "content") == "a");
  if (exchange_folders(a, b)) {
    CHECK(bytes_of(a / "content") == "a");
  } else {
    skip("this file system cannot exchange folders");
  }
  const std::string before = bytes_of(b / "content");
  CHECK_THROWS_AS(swap_folders_by_renaming(folder.path() / "missing", b), InputError);
  CHECK(bytes_of(b / "content") == before);
  CHECK(entries(folder.path()) == 2);
}

TEST_CASE("an earlier output that a killed process had set aside is put back by the next one, or removed") {
  const TemporaryFolder folder;
  const fs::path target = folder.path() / "out";
  const auto set_aside = [&](const std::string& content) {
    fs::path aside = swap_name(target);
    make_output(folder.path() / "made", content);
    fs::rename(folder.path() / "made", aside);
    return aside;
  };
  (void)set_aside("earlier");
  make_output(folder.path() / "other", "other");  // no output at another path touches it
  CHECK_FALSE(fs::exists(target));
  { const OutputFolder out(target, "build"); }
  CHECK(bytes_of(target / "content") == "earlier");
  CHECK(entries(folder.path()) == 2);

  const fs::path late = set_aside("before that");
  {
    const LeftoverLock held(late);  // its process is alive
    const OutputFolder out(target, "build");
    CHECK(bytes_of(late / "content") == "before that");
  }
  { const OutputFolder out(target, "build"); }
  CHECK_FALSE(fs::exists(late));
  CHECK(bytes_of(target / "content") == "earlier");

  const fs::path only = set_aside("the only one");
  fs::remove_all(target);
  fs::create_directory(target);
  write_text(target / "theirs", "precious");
  CHECK_THROWS_AS(OutputFolder(target, "build"), InputError);
  CHECK(bytes_of(target / "theirs") == "precious");
  CHECK(bytes_of(only / "content") == "the only one");
}

TEST_CASE("folders with the longest name that a file system takes are swapped too") {
  const TemporaryFolder folder;
  const fs::path fresh = folder.path() / "fresh";
  for (const std::size_t length : {204, 205, 255}) {
    CAPTURE(length);
    const fs::path target = folder.path() / std::string(length, 'n');
    make_output(target, "old");
    make_output(fresh, "new");
    swap_folders_by_renaming(fresh, target);
    CHECK(bytes_of(target / "content") == "new");
    CHECK(bytes_of(fresh / "content") == "old");
  }
}

TEST_CASE("a file appears at commit, replaces an earlier one, and vanishes without commit") {
  const TemporaryFolder folder;
  const fs::path target = folder.path() / "result.json";
  {
    AtomicFile file(target);
    file.stream() << "one";
    CHECK_FALSE(fs::exists(target));
    file.commit();
    CHECK_THROWS_AS(file.commit(), std::invalid_argument);
  }
  CHECK(bytes_of(target) == "one");
  {
    AtomicFile file(target);
    file.stream() << "half";
  }
  CHECK(bytes_of(target) == "one");
  CHECK(entries(folder.path()) == 1);
}

TEST_CASE("a file that cannot be written is refused with the reason") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(AtomicFile(folder.path()), folder.path().string() + ": is not a regular file, name another output");
  CHECK_THROWS_WITH(AtomicFile("/dev/null"), "/dev/null: is not a regular file, name another output");
  const fs::path missing = folder.path() / "missing" / "file";
  CHECK_THROWS_WITH(AtomicFile(missing), missing.string() + ": cannot be written, its folder does not exist");
  AtomicFile broken(folder.path() / "file");
  broken.stream().setstate(std::ios::badbit);
  CHECK_THROWS_WITH(broken.commit(),
                    (folder.path() / "file").string() + ": could not be written to the end, is the disk full?");
}

TEST_CASE("JSON with a name that is not UTF-8 is written all the same") {
  const TemporaryFolder folder;
  write_json(folder / "a.json", {{"name", "caf\xe9.jpg"}});
  CHECK(bytes_of(folder / "a.json") == json_text({{"name", "caf\xef\xbf\xbd.jpg"}}));
  CHECK(nlohmann::json::parse(bytes_of(folder / "a.json"))["name"] == "caf\xef\xbf\xbd.jpg");
}

}  // namespace
}  // namespace lumatlas
