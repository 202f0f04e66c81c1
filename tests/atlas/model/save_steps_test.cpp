// SPDX-License-Identifier: GPL-3.0-or-later
// A save is whole or absent: it is looked at before each of its steps, where it may be killed, and each of them fails
// once. The steps are the calls by which files appear, change their names and go: this program has its own of them.
#include <fcntl.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "atlas/model/model_file.h"
#include "mesh/base/errors.h"
#include "tests/support/scenes/plain_model.h"
#include "tests/support/scenes/view_parts.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tests/support/temporary_folder.h"

namespace {

// Called before each step; false: the step fails.
std::function<bool()> before_step;

bool is_rename_on_disk = true;   // whether fsync() was called since the last rename()
bool was_removed_early = false;  // whether a file was removed while that was not so

bool may_go_on() {
  if (!before_step || before_step()) return true;
  errno = EIO;
  return false;
}

}  // namespace

// The functions that std::filesystem calls. The C library names their parameters otherwise.
// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name)
extern "C" int rename(const char* from, const char* to) noexcept {
  if (!may_go_on()) return -1;
  is_rename_on_disk = false;
  return static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

extern "C" int fsync(int descriptor) {
  is_rename_on_disk = true;
  return static_cast<int>(syscall(SYS_fsync, descriptor));
}

extern "C" int remove(const char* path) noexcept {
  if (!may_go_on()) return -1;
  was_removed_early = was_removed_early || !is_rename_on_disk;
  if (unlink(path) == 0) return 0;
  return errno == EISDIR || errno == EPERM ? rmdir(path) : -1;
}
// NOLINTEND(readability-inconsistent-declaration-parameter-name)

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

// While it lives, steps are observed.
class Observed {
 public:
  explicit Observed(std::function<bool()> observer) { before_step = std::move(observer); }
  ~Observed() { before_step = nullptr; }
  Observed(const Observed&) = delete;
  Observed& operator=(const Observed&) = delete;
};

std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    const bool is_temporary = name.starts_with(".lumatlas-");
    if (entry.is_regular_file() && !is_temporary) files[name] = bytes_of(entry.path());
  }
  return files;
}

// The photographs, masks and gains of a model, which say which one it is.
struct Shown {
  std::vector<std::vector<std::uint8_t>> photographs, trust;
  std::vector<glm::dvec3> gains;
  std::vector<glm::u8vec3> colors;
  bool operator==(const Shown&) const = default;
};

Shown shown(const Snapshot& snapshot) {
  Shown all;
  all.gains = snapshot.gains;
  all.colors = snapshot.vertex_colors.get();
  for (const auto& view : snapshot.views) {
    all.photographs.push_back(view->photograph->whole().rgb);
    all.trust.push_back(view->mask->trust.all());
  }
  return all;
}

Shown read_back(const fs::path& folder) {
  return shown(read_model(folder).snapshot);
}

// The small model, or, with another number, one with other photographs, masks and colours at the same places.
Snapshot model_number(std::uint8_t number) {
  Snapshot snapshot = small_snapshot();
  for (auto& view : snapshot.views) {
    if (!view) continue;
    auto other = std::make_shared<StoredView>(*view);
    change_colors(*other, [&](std::uint8_t value) { return value ^ number; });
    for (std::uint8_t& value : own_mask(*other).trust.values()) value = static_cast<std::uint8_t>(value ^ number);
    view = other;
  }
  FallbackColors::Colors colors = snapshot.vertex_colors.get();
  for (glm::u8vec3& color : colors) color.r = static_cast<std::uint8_t>(color.r ^ number);
  snapshot.vertex_colors = std::move(colors);
  return snapshot;
}

TEST_CASE("killed between any two steps, a save leaves the earlier model or the new one, whole") {
  const TemporaryFolder folder, moments, fresh;
  write_model(folder.path(), model_number(0), {});
  const Shown earlier = read_back(folder.path());
  write_model(fresh.path(), model_number(1), {});
  const Shown later = read_back(fresh.path());
  REQUIRE(earlier != later);

  std::size_t steps = 0;
  {
    const Observed observed([&] {
      fs::copy(folder.path(), moments / std::to_string(steps++), fs::copy_options::recursive);
      return true;
    });
    write_model(folder.path(), model_number(1), {});
  }
  fs::copy(folder.path(), moments / std::to_string(steps), fs::copy_options::recursive);
  const std::map<std::string, std::string> whole = contents(fresh.path());
  REQUIRE(steps >= whole.size());  // each file is put into its place

  std::optional<std::size_t> committed;
  for (std::size_t moment = 0; moment <= steps; ++moment) {
    CAPTURE(moment);
    const fs::path at = moments / std::to_string(moment);
    const Shown read = read_back(at);
    const bool is_later = read == later;
    CHECK((is_later || read == earlier));
    if (committed) CHECK(is_later);
    if (is_later && !committed) committed = moment;
    // The next save removes what the interrupted one left.
    write_model(at, model_number(1), {});
    CHECK(contents(at) == whole);
    CHECK(read_back(at) == later);
  }
  REQUIRE(committed);
  CHECK(*committed > 0);
  CHECK(contents(folder.path()) == whole);
}

TEST_CASE("a save that fails at any step leaves the folder as it was") {
  const TemporaryFolder folder;
  write_model(folder.path(), model_number(0), {});
  const std::map<std::string, std::string> before = contents(folder.path());
  bool is_written = false;
  std::size_t failing = 0;
  for (; !is_written; ++failing) {
    CAPTURE(failing);
    std::size_t step = 0;
    try {
      const Observed observed([&] { return step++ != failing; });
      write_model(folder.path(), model_number(1), {});
      is_written = true;
    } catch (const InputError& error) {
      CHECK_THAT(error.what(), Catch::Contains("cannot be written"));
      CHECK(contents(folder.path()) == before);
    }
  }
  CHECK(failing > before.size());  // each file once
  const TemporaryFolder fresh;
  write_model(fresh.path(), model_number(1), {});
  CHECK(read_back(folder.path()) == read_back(fresh.path()));
}

TEST_CASE("the earlier model's files are removed only once the disk has the new tileset.json") {
  const TemporaryFolder folder, fresh;
  write_model(folder.path(), model_number(0), {});
  was_removed_early = false;
  write_model(folder.path(), model_number(1), {});
  CHECK_FALSE(was_removed_early);
  write_model(fresh.path(), model_number(1), {});
  CHECK(contents(folder.path()) == contents(fresh.path()));  // nothing is left of the earlier model
}

TEST_CASE("a reader that is still at an earlier model never meets a photograph of a later one") {
  const TemporaryFolder folder;
  write_model(folder.path(), model_number(0), {});
  const std::string earlier = bytes_of(folder / "tileset.json");
  for (const std::uint8_t number : std::vector<std::uint8_t>{1, 2, 3}) {
    write_model(folder.path(), model_number(number), {});
    const std::string later = bytes_of(folder / "tileset.json");
    (void)folder.with_file("tileset.json", earlier);  // as the reader has it
    CHECK_THROWS_WITH(read_model(folder.path()), Catch::Contains("no such file"));
    (void)folder.with_file("tileset.json", later);
  }
}

TEST_CASE("a model that is read during 200 saves is always one of those saved, whole") {
  const TemporaryFolder folder, other;
  write_model(folder.path(), model_number(0), {});
  write_model(other.path(), model_number(1), {});
  const Shown even = read_back(folder.path()), odd = read_back(other.path());
  std::atomic<bool> is_saving = true;
  std::thread saving([&] {
    for (int save = 1; save <= 200; ++save) write_model(folder.path(), model_number(save % 2 == 0 ? 0 : 1), {});
    is_saving = false;
  });
  std::size_t evens = 0, odds = 0, others = 0;
  std::string failure;
  while (is_saving) {
    try {
      const Shown read = read_back(folder.path());
      ++(read == even ? evens : read == odd ? odds : others);
      (void)read_model_facts(folder.path());
    } catch (const std::exception& error) {
      failure = error.what();
    }
  }
  saving.join();
  CHECK_THAT(failure, Catch::Equals(""));
  CHECK(evens > 0);
  CHECK(odds > 0);
  CHECK(others == 0);
}

constexpr const char* kFolderToSaveTo = "LUMATLAS_TEST_SAVES_TO";

// Runs in a program of its own, which the next test starts and kills; elsewhere it does nothing.
TEST_CASE("saves without end", "[.]") {
  const char* const folder = std::getenv(kFolderToSaveTo);
  if (folder == nullptr) return;
  for (std::uint8_t number = 0;; number ^= 1) write_model(folder, model_number(number), {});
}

// Returns once another process has put a file into this one's place, after a minute at the latest.
void wait_for_save(const fs::path& file) {
  const fs::file_time_type before = fs::last_write_time(file);
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (fs::last_write_time(file) == before && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

// The environment variable LUMATLAS_TEST_KILLS says how often; each takes a fifth of a second of processor time.
TEST_CASE("killed at moments by chance, saves leave a whole model") {
  const TemporaryFolder folder, other;
  write_model(folder.path(), model_number(0), {});
  write_model(other.path(), model_number(1), {});
  const Shown even = read_back(folder.path()), odd = read_back(other.path());
  REQUIRE(setenv(kFolderToSaveTo, folder.path().c_str(), 1) == 0);
  std::mt19937_64 random(4);
  std::size_t changes = 0;
  bool was_even = true;
  const char* const kills = std::getenv("LUMATLAS_TEST_KILLS");
  const int most = kills == nullptr ? 25 : std::atoi(kills);
  for (int killed = 0; killed < most; ++killed) {
    CAPTURE(killed);
    std::string program = "/proc/self/exe", test = "saves without end";
    std::array<char*, 3> arguments{program.data(), test.data(), nullptr};
    pid_t child = 0;
    REQUIRE(posix_spawn(&child, program.c_str(), nullptr, nullptr, arguments.data(), environ) == 0);
    for (std::uint64_t saves = 1 + random() % 2; saves > 0; --saves) wait_for_save(folder / "tileset.json");
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 20000));
    REQUIRE(kill(child, SIGKILL) == 0);
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(WIFSIGNALED(status));
    const Shown read = read_back(folder.path());
    const bool is_even = read == even;
    CHECK((is_even || read == odd));
    changes += is_even != was_even ? 1 : 0;
    was_even = is_even;
  }
  CHECK(changes > 0);
  write_model(folder.path(), model_number(1), {});
  CHECK(contents(folder.path()) == contents(other.path()));  // nothing is left of those that were killed
}

}  // namespace
}  // namespace lumatlas
