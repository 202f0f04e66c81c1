// SPDX-License-Identifier: GPL-3.0-or-later
// Nothing takes the place of a good model but a better one, whichever command would put it there.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/model/model_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"

namespace lumatlas {
namespace {

using nlohmann::json;

// A copy of the scene whose photographs may be damaged, and a place for a model of it.
struct Changed {
  TemporaryFolder folder;
  std::string scene = (folder / "scene").string();
  std::string model = (folder / "model").string();

  Changed() { fs::copy(made().scene, scene, fs::copy_options::recursive); }

  // From the photograph of this number on, by name, the second half of each is missing.
  void halve_photographs(std::size_t first) const {
    std::vector<std::string> names = names_in(fs::path(scene) / "images");
    std::sort(names.begin(), names.end());
    for (std::size_t i = first; i < names.size(); ++i) {
      const fs::path photograph = fs::path(scene) / "images" / names[i];
      fs::resize_file(photograph, fs::file_size(photograph) / 2);
    }
  }
  void put_earlier_model() const { fs::copy(made().model, model, fs::copy_options::recursive); }
  [[nodiscard]] bool is_earlier_model() const {
    return bytes_of(fs::path(model) / "plan.json") == bytes_of(fs::path(made().model) / "plan.json");
  }
  [[nodiscard]] bool leaves_nothing_temporary() const {
    const std::vector<std::string> names = names_in(folder.path());
    return std::none_of(names.begin(), names.end(),
                        [](const std::string& name) { return name.starts_with(".lumatlas-"); });
  }
  [[nodiscard]] Arguments watching(const std::string& idle_s) const {
    return {"build", scene, kLargeCells, "-o", model, "--watch", "--idle", idle_s, "--refine", "none", "--quiet"};
  }
};

std::string last_line(const std::string& text) {
  const std::size_t end = text.size() - 1;
  return text.substr(text.rfind('\n', end - 1) + 1);
}

void check_refused(const Outcome& outcome, const std::string& part) {
  INFO(outcome.err);
  CHECK(outcome.status == 1);
  CHECK(outcome.out.empty());
  CHECK_THAT(last_line(outcome.err), Catch::StartsWith("lumatlas: ") && Catch::Contains(part));
}

TEST_CASE("a model without photographs is not saved, whether something was at its place or not") {
  const Changed changed;
  const Arguments nothing{"build",  made().scene,          "-o",    changed.model,
                          "--set",  "coverage.demand=off", "--set", "coverage.ideal-distance=1e-320",
                          "--quiet"};
  const std::string part =
      "none of the 12 photographs is stored, so that no model was saved: 0 see nothing of the mesh";
  check_refused(lumatlas_here(nothing), part);
  CHECK_FALSE(fs::exists(changed.model));
  changed.put_earlier_model();
  check_refused(lumatlas_here(nothing), part);
  CHECK(changed.is_earlier_model());
  Arguments file = nothing;
  file[3] = changed.model + ".glb";
  check_refused(lumatlas_here(file), part);
  CHECK_FALSE(fs::exists(file[3]));
  CHECK(changed.leaves_nothing_temporary());
}

TEST_CASE("build --watch that is ended while photographs are half written leaves the earlier model") {
  const Changed changed;
  changed.halve_photographs(0);
  for (const bool earlier : {false, true}) {
    CAPTURE(earlier);
    if (earlier) changed.put_earlier_model();
    const Run run({"build", changed.scene, "-o", changed.model, "--watch"});
    Run::wait_until([&] { return run.err().find("waiting for photographs") != std::string::npos; });
    std::this_thread::sleep_for(std::chrono::seconds(4));  // some looks at the folder, one a second
    run.send(SIGINT);
    const Outcome outcome = run.wait();
    CHECK(outcome.status == 1);
    CHECK_THAT(last_line(outcome.err), Catch::Contains("none of the 12 photographs is stored") &&
                                           Catch::Contains("12 did not come, or are damaged"));
    CHECK(fs::exists(changed.model) == earlier);
    if (earlier) CHECK(changed.is_earlier_model());
    CHECK(changed.leaves_nothing_temporary());
  }
}

TEST_CASE("a model that misses most photographs is saved where nothing was, and replaces no other") {
  const Changed changed;
  changed.halve_photographs(3);
  // Where nothing was, the model of what came is saved, and told.
  const Outcome first = lumatlas_here(changed.watching("2"));
  INFO(first.err);
  REQUIRE(first.status == 0);
  CHECK_THAT(first.out, Catch::Contains("views stored"));
  fs::remove_all(changed.model);
  changed.put_earlier_model();
  const std::string sentence =
      changed.model +
      ": stays as it is, because the new model misses most of its photographs (3 of 12 could be used"
      "): name another output, or remove the earlier model";
  check_refused(lumatlas_here(changed.watching("2")), sentence);
  CHECK(changed.is_earlier_model());
  check_refused(lumatlas_here({"build", changed.scene, "-o", changed.model, "--skip-bad", "--refine", "none"}),
                sentence);
  CHECK(changed.is_earlier_model());
  CHECK(changed.leaves_nothing_temporary());
}

TEST_CASE("fewer photographs because fewer were asked for are no reason to refuse") {
  const Changed changed;
  changed.put_earlier_model();
  CHECK(
      lumatlas_here({"build", made().scene, kLargeCells, "-o", changed.model, "--max-views", "2", "--quiet"}).status ==
      0);
  CHECK(lumatlas_here({"build", made().scene, kLargeCells, "-o", changed.model, "--set", "stream.choice=uniform",
                       "--max-views", "2", "--quiet"})
            .status == 0);
  CHECK(lumatlas_here({"build", made().scene, kLargeCells, "-o", changed.model, "--hold", "2", "--quiet"}).status == 0);
}

TEST_CASE("a model without photographs, as earlier versions saved them, is not exported over anything") {
  const Changed changed;
  const Model model = read_model(made().model);
  const Atlas empty(model.snapshot.surface, 1);
  fs::create_directory(changed.model);
  write_model(changed.model, empty.snapshot(), model.validity);
  for (const char* const name : {"out.glb", "out", "out.html"}) {
    CAPTURE(name);
    const std::string out = (changed.folder / name).string();
    check_failure(lumatlas_here({"export", changed.model, "-o", out, "--quiet", "--to",
                                 std::string(name) == "out.glb" ? "glb" : "web"}),
                  changed.model + ": holds no photograph");
    CHECK_FALSE(fs::exists(out));
  }
}

}  // namespace
}  // namespace lumatlas
