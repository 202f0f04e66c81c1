// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes and models that cannot be written to: on a CD, a share, a snapshot, or another user's.
#include <linux/capability.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"

namespace lumatlas {
namespace {

// Takes from this thread the right of a system's administrator to write anywhere.
bool give_up_write_rights() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> sets{};
  if (syscall(SYS_capget, &header, sets.data()) != 0) return false;
  sets[0].effective &= ~(1u << CAP_DAC_OVERRIDE);
  sets[0].permitted &= ~(1u << CAP_DAC_OVERRIDE);
  return syscall(SYS_capset, &header, sets.data()) == 0;
}

// Runs the program on a thread that has no more rights than the files' permissions give.
Outcome lumatlas_without_rights(const Arguments& arguments) {
  Outcome outcome;
  bool is_ready = false;
  std::thread([&] {
    is_ready = give_up_write_rights();
    if (is_ready) outcome = lumatlas_here(arguments);
  }).join();
  REQUIRE(is_ready);
  return outcome;
}

// Copies a folder and takes away everyone's permission to write into the copy, until this object ends.
class ReadOnlyCopy {
 public:
  explicit ReadOnlyCopy(const std::string& of) {
    fs::copy(of, path_, fs::copy_options::recursive);
    set(fs::perms::owner_read | fs::perms::owner_exec);
  }
  ~ReadOnlyCopy() { set(fs::perms::owner_all); }
  ReadOnlyCopy(const ReadOnlyCopy&) = delete;
  ReadOnlyCopy& operator=(const ReadOnlyCopy&) = delete;

  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  void set(fs::perms permissions) const {
    fs::permissions(path_, permissions);
    for (const auto& entry : fs::recursive_directory_iterator(path_)) {
      if (entry.is_directory()) fs::permissions(entry.path(), permissions);
    }
  }

  TemporaryFolder folder_;
  fs::path path_ = folder_ / "copy";
};

TEST_CASE("a scene that is read-only is inspected and built, and refused as the place of outputs") {
  const ReadOnlyCopy scene(made().scene);
  const TemporaryFolder elsewhere;
  CHECK(lumatlas_without_rights({"inspect", scene.path(), "--quiet"}).status == 0);
  CHECK(lumatlas_without_rights({"build", scene.path(), "-o", (elsewhere / "model").string(), "--hold", "4", "--quiet"})
            .status == 0);
  const std::string inside = scene.path() + "/model";
  check_failure(lumatlas_without_rights({"build", scene.path(), "-o", inside, "--quiet"}), inside + ": cannot be made");
  check_failure(lumatlas_without_rights({"build", scene.path(), "-o", inside + ".glb", "--quiet"}),
                inside + ".glb: cannot be written");
  check_failure(lumatlas_without_rights({"mesh", scene.path(), "-o", inside + ".ply", "--quiet"}),
                inside + ".ply: cannot be written");
  check_failure(lumatlas_without_rights({"capture", scene.path() + "/images", "-o", inside, "--quiet"}),
                inside + ": cannot be made");
  CHECK(names_in(scene.path()).size() == names_in(made().scene).size());
}

TEST_CASE("the scores of a model that is read-only are printed, and told where a report can go") {
  const ReadOnlyCopy model(made().model);
  const Arguments validate{"validate", model.path(), "--views", made().scene, "--no-alignment", "--baselines", "none"};
  const Outcome printed = lumatlas_without_rights(validate);
  CHECK(printed.status == 0);
  CHECK_THAT(printed.out, Catch::Contains("held-out views (--hold 4"));
  CHECK_THAT(printed.err, Catch::EndsWith("no report: " + model.path() +
                                          "/report cannot be written to; name a folder for it with -o\n"));
  Arguments inside = validate, elsewhere = validate;
  inside.insert(inside.end(), {"-o", model.path() + "/scores", "--quiet"});
  check_failure(lumatlas_without_rights(inside), model.path() + "/scores: cannot be made");
  const TemporaryFolder folder;
  elsewhere.insert(elsewhere.end(), {"-o", (folder / "report").string(), "--quiet"});
  CHECK(lumatlas_without_rights(elsewhere).status == 0);
  CHECK(fs::is_regular_file(folder / "report" / "index.html"));
}

}  // namespace
}  // namespace lumatlas
