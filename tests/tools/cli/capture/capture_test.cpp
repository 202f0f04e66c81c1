// SPDX-License-Identifier: GPL-3.0-or-later
// The steps of `lumatlas capture`, and what is told where one fails.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "atlas/images/photograph.h"
#include "tests/support/skip.h"
#include "tests/tools/cli/capture/capture_surroundings.h"
#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"
#include "tools/base/process/child_process.h"

namespace lumatlas {
namespace {

using namespace capturing;

TEST_CASE("capture goes from photographs to a model, and its folder is a scene that validate reads") {
  const Surroundings room;
  const Outcome outcome = lumatlas_here(room.arguments());
  const json result = printed(outcome);
  CHECK(room.calls() == kAllCalls);
  CHECK(result["photographs"]["count"] == 12);
  CHECK(result["photographs"]["missed"].empty());
  CHECK(result["reconstructions"] == json{12});
  CHECK(result["steps"].size() == 5);
  CHECK(done_before(result).empty());
  CHECK_THAT(outcome.err, Catch::Contains("step 3 of 5, mapping: poses and points") &&
                              Catch::Contains("12 of 12 photographs are placed") &&
                              Catch::Contains("taken as of one lens"));
  CHECK(json::parse(bytes_of(room.model() / "plan.json"))["summary"]["views"]["offered"] == 9);
  for (const std::string& name : room.names()) {
    CHECK(fs::read_symlink(room.work() / "images" / name) == fs::canonical(room.photographs() / name));
  }
  CHECK(lumatlas_here({"inspect", room.work().string(), "--quiet"}).status == 0);
}

TEST_CASE("capture does again only what its inputs ask for") {
  const Surroundings room;
  printed(lumatlas_here(room.arguments()));
  (void)room.calls();

  json again = printed(lumatlas_here(room.arguments()));
  CHECK(done_before(again) == "features matching mapping mesh build ");
  CHECK(room.calls().empty());

  // Without --json, as the build that made the model, with what to do next.
  Arguments in_words = room.arguments();
  in_words.pop_back();
  const Outcome told = lumatlas_here(in_words);
  CHECK_THAT(told.out, Catch::Contains("views stored"));
  CHECK_THAT(told.err, Catch::Contains("step 5 of 5, build: done before") && Catch::Contains("lumatlas validate"));

  Arguments fewer = room.arguments();
  fewer.insert(fewer.end(), {"--max-views", "4"});
  again = printed(lumatlas_here(fewer));
  CHECK(done_before(again) == "features matching mapping mesh ");

  fs::remove(room.work() / "mesh.ply");
  again = printed(lumatlas_here(fewer));
  CHECK(done_before(again) == "features matching mapping ");
  CHECK(room.calls().empty());

  // One more goes into the database that is there.
  const fs::path one_more = room.photographs() / "one-more.png";
  fs::copy(room.photographs() / names_in(room.photographs()).front(), one_more);
  again = printed(lumatlas_here(fewer));
  CHECK(done_before(again).empty());
  CHECK(again["photographs"]["count"] == 13);
  CHECK(room.calls() == kAllCalls);
  CHECK(fs::remove(room.bin() / "kept"));

  // A photograph that is gone, or is another file now, makes everything new.
  fs::remove(one_more);
  again = printed(lumatlas_here(fewer));
  CHECK(room.calls() == kAllCalls);
  CHECK_FALSE(fs::exists(room.bin() / "kept"));
  const fs::path photograph = room.photographs() / names_in(room.photographs()).front();
  fs::last_write_time(photograph, fs::last_write_time(photograph) + std::chrono::seconds(1));
  again = printed(lumatlas_here(fewer));
  CHECK(done_before(again).empty());
  CHECK(room.calls() == kAllCalls);
  CHECK_FALSE(fs::exists(room.bin() / "kept"));
}

TEST_CASE("of several reconstructions capture takes the largest, and counts photographs without a place") {
  const Surroundings room;
  fs::create_directory(room.bin() / "models" / "0");
  std::ofstream(room.bin() / "models/0/cameras.txt") << "1 PINHOLE 64 48 50 50 32 24\n";
  std::ofstream(room.bin() / "models/0/images.txt") << "1 1 0 0 0 0 0 0 1 only.png\n\n";
  const fs::path first = room.photographs() / "0-of-nothing.png";
  fs::copy(room.photographs() / names_in(room.photographs()).front(), first);
  const Outcome outcome = lumatlas_here(room.arguments());
  const json result = printed(outcome);
  CHECK(result["reconstructions"] == json{12, 1});
  CHECK(result["photographs"]["count"] == 13);
  CHECK(result["photographs"]["missed"] == json{"0-of-nothing.png"});
  CHECK_THAT(outcome.err,
             Catch::Contains("12 of 13 photographs are placed, in the largest of 2 reconstructions that do "
                             "not hang together (12, 1 photographs)") &&
                 Catch::Contains("without a place: 0-of-nothing.png"));
}

TEST_CASE("a capture that lost most of its photographs does not replace the model of an earlier one") {
  const Surroundings room;
  printed(lumatlas_here(room.arguments()));
  const std::string plan = bytes_of(room.model() / "plan.json");
  const std::vector<std::string> names = names_in(room.photographs());
  for (int copy = 0; copy < 13; ++copy) {
    fs::copy(room.photographs() / names.front(),
             room.photographs() / ("without-a-place-" + std::to_string(copy) + ".png"));
  }
  Arguments quiet = room.arguments();
  quiet.push_back("--quiet");
  check_failure(lumatlas_here(quiet), "the new model misses most of its photographs (9 of 22 could be used");
  CHECK(bytes_of(room.model() / "plan.json") == plan);
}

TEST_CASE("without COLMAP one sentence says what to install") {
  const Surroundings room(false);
  Arguments arguments = room.arguments();
  arguments.push_back("--quiet");
  check_failure(lumatlas_here(arguments), "apt install colmap");
}

TEST_CASE("where COLMAP fails, its last words and its log are told, and what was done stays done") {
  const Surroundings room;
  Arguments quiet = room.arguments();
  quiet.push_back("--quiet");
  const fs::path failing = room.note("failing");
  check_failure(lumatlas_here(quiet),
                "colmap mapper failed with exit status 4 and said 'bundle adjustment lost its way': see " +
                    (room.work() / "log/mapping.txt").string());
  CHECK_FALSE(fs::exists(room.model()));
  fs::remove(failing);
  const fs::path blind = room.note("blind");
  check_failure(lumatlas_here(quiet), "COLMAP placed none of its 12 photographs");
  fs::remove(blind);
  (void)room.calls();
  CHECK(done_before(printed(lumatlas_here(quiet))) == "features matching ");
  CHECK(room.calls() == "mapper ");
}

TEST_CASE("where COLMAP places nothing, the sentence says why and what to do") {
  const Surroundings room;
  Arguments quiet = room.arguments();
  quiet.push_back("--quiet");
  const auto refused_with = [&](const char* note, const std::string& part) {
    const fs::path file = room.note(note);
    check_failure(lumatlas_here(quiet), part);
    fs::remove(file);
    CHECK_FALSE(fs::exists(room.model()));
  };
  refused_with("featureless",
               "COLMAP found nothing that can be told apart in any of the 1 photographs: they are blank");
  refused_with("matchless", "COLMAP placed none of its 12 photographs: no two photographs were found to show the same");
  refused_with("pairless", "walk between photographs rather than turn on the spot");
  CHECK(done_before(printed(lumatlas_here(quiet))) == "features matching ");
}

// Squares of grey by chance, other ones in each photograph.
Photograph unrelated_photograph(std::mt19937& random) {
  Photograph photograph{320, 240, std::vector<std::uint8_t>(3 * 320 * 240), {}};
  std::vector<std::uint8_t> squares(40 * 30);
  for (std::uint8_t& square : squares) square = static_cast<std::uint8_t>(random() % 256);
  for (std::size_t i = 0; i < photograph.rgb.size(); ++i) {
    const std::size_t x = i / 3 % 320, y = i / 3 / 320;
    photograph.rgb[i] = squares[y / 8 * 40 + x / 8];
  }
  return photograph;
}

TEST_CASE("the COLMAP that is installed says why it places nothing as the stand-in does") {
  if (find_program("colmap").empty()) return skip("COLMAP is not installed");
  const TemporaryFolder folder;
  std::mt19937 random(1);
  fs::create_directory(folder / "blank");
  fs::create_directory(folder / "unrelated");
  for (const char* const name : {"a.png", "b.png", "c.png"}) {
    write_image(folder / "blank" / name, {160, 120, std::vector<std::uint8_t>(3 * 160 * 120, 128), {}});
    write_image(folder / "unrelated" / name, unrelated_photograph(random));
  }
  const std::string model = (folder / "model").string();
  check_failure(lumatlas_here({"capture", (folder / "blank").string(), "-o", model, "--quiet"}),
                "COLMAP found nothing that can be told apart in any of the 3 photographs");
  fs::remove_all(folder / "model-capture");
  check_failure(lumatlas_here({"capture", (folder / "unrelated").string(), "-o", model, "--quiet"}),
                "COLMAP placed none of its 3 photographs: no two photographs were found to show the same");
}

TEST_CASE("one photograph of another size has a lens of its own, and the others share theirs") {
  const Surroundings room;
  const std::vector<std::string> names = room.names();
  write_image(room.photographs() / "wider.png", {80, 48, std::vector<std::uint8_t>(80 * 48 * 3, 99), {}});
  const Outcome outcome = lumatlas_here(room.arguments());
  printed(outcome);
  CHECK_THAT(outcome.err, Catch::Contains("taken as of 2 lenses, for their sizes or cameras differ: 12 like " +
                                          names.front() + ", 1 like wider.png"));
  std::string all;
  for (const std::string& name : names) all += name + ' ';
  CHECK(bytes_of(room.bin() / "lists") == all + "\nwider.png \n");
  const std::string calls = bytes_of(room.bin() / "calls");
  CHECK_THAT(calls.substr(0, calls.find('\n')), Catch::Contains("--ImageReader.single_camera 1"));
  CHECK_THAT(calls, Catch::Contains("--ImageReader.single_camera 0 --ImageReader.single_camera_per_image 1"));
}

TEST_CASE("masks are given to COLMAP and to the build, and are no photographs where they lie among them") {
  const Surroundings room;
  const std::vector<std::string> names = room.names();
  const fs::path masks = room.photographs() / "masks";
  fs::create_directory(masks);
  Arguments masked = room.arguments();
  masked.insert(masked.end(), {"--masks", masks.string()});
  check_failure(lumatlas_here(masked), "has a mask of none of the 12 photographs; that of " + names.front() +
                                           " would be " + names.front() + ".png");
  write_image(masks / names.front(), {64, 48, std::vector<std::uint8_t>(64 * 48 * 3, 255), {}});
  const json first = printed(lumatlas_here(masked));
  CHECK(first["photographs"]["count"] == 12);
  CHECK_THAT(bytes_of(room.bin() / "calls"),
             Catch::Contains("--ImageReader.mask_path " + (room.work() / "colmap-masks").string()));
  CHECK(fs::equivalent(room.work() / "colmap-masks" / (names.front() + ".png"), masks / names.front()));
  CHECK(json::parse(lumatlas_here({"inspect", room.work().string(), "--json", "--quiet"}).out)["views"]["masked"] == 1);
  CHECK(done_before(printed(lumatlas_here(masked))) == "features matching mapping mesh build ");
  // Without them everything is new.
  fs::rename(masks, room.work().parent_path() / "elsewhere");
  CHECK(done_before(printed(lumatlas_here(room.arguments()))).empty());
  CHECK_FALSE(fs::exists(room.work() / "masks"));
}

TEST_CASE("without another word the mesh is made of matched photographs") {
  const Surroundings room;
  Arguments arguments = room.arguments();
  arguments.erase(std::find(arguments.begin(), arguments.end(), "--from"));
  arguments.erase(std::find(arguments.begin(), arguments.end(), "points"));
  const Outcome outcome = lumatlas_here(arguments);
  CHECK(printed(outcome)["steps"].size() == 5);
  CHECK_THAT(outcome.err, Catch::Contains("step 4 of 5, mesh: from depths of the photographs"));
  CHECK_FALSE(fs::exists(room.work() / "stereo"));
  CHECK(done_before(printed(lumatlas_here(arguments))) == "features matching mapping mesh build ");
  CHECK(done_before(printed(lumatlas_here(room.arguments()))) == "features matching mapping ");
}

TEST_CASE("the mesh is made of the points that are given, and again when they change") {
  const Surroundings room;
  printed(lumatlas_here(room.arguments()));
  Arguments dense = room.arguments();
  dense.erase(std::find(dense.begin(), dense.end(), "--from"));
  dense.erase(std::find(dense.begin(), dense.end(), "points"));
  dense.insert(dense.end(), {"--points", made().scene + "/mesh.ply"});
  const Outcome outcome = lumatlas_here(dense);
  CHECK(done_before(printed(outcome)) == "features matching mapping ");
  CHECK_THAT(outcome.err, Catch::Contains("mesh: from " + made().scene + "/mesh.ply and the photographs"));
  CHECK(done_before(printed(lumatlas_here(dense))) == "features matching mapping mesh build ");
}

TEST_CASE("a folder of photographs may have any name, and what was done there is known again") {
  for (const char* const name : {"caf\xe9", "two\nlines", "hexadecimal:"}) {
    CAPTURE(name);
    const Surroundings room;
    const fs::path photographs = room.work().parent_path() / name,
                   model = room.work().parent_path() / (std::string("m") + name);
    fs::rename(room.photographs(), photographs);
    // The first capture matches its photographs for a mesh, the others take the points alone, which is quicker.
    Arguments arguments{"capture", photographs.string(), "-o", model.string(), "--json"};
    if (name != std::string("caf\xe9")) arguments.insert(arguments.end(), {"--from", "points"});
    CHECK(done_before(printed(lumatlas_here(arguments))).empty());
    CHECK_FALSE(room.calls().empty());
    CHECK(done_before(printed(lumatlas_here(arguments))) == "features matching mapping mesh build ");
    CHECK(room.calls().empty());
  }
}

TEST_CASE("photographs whose names COLMAP's list or a model cannot hold are refused before anything is done") {
  for (const auto& [name, part] : {std::pair{"line\nbreak.png", "holds a line break"},
                                   {" blank.png", "begins with a blank"},
                                   {"caf\xe9.png", "its name is not UTF-8"}}) {
    CAPTURE(name);
    const Surroundings room;
    fs::copy(room.photographs() / room.names().front(), room.photographs() / name);
    check_failure(lumatlas_here(room.arguments()), part);
    CHECK(room.calls().empty());
    CHECK_FALSE(fs::exists(room.work()));
  }
}

TEST_CASE("an interruption ends COLMAP too, and the next run goes on") {
  const Surroundings room;
  const fs::path slow = room.note("slow"), at_work = room.bin() / "at-work";
  const Run run(room.arguments());
  for (int wait = 0; wait < 3000 && bytes_of(at_work).empty(); ++wait) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const std::string process = bytes_of(at_work);
  REQUIRE_FALSE(process.empty());
  run.send(SIGINT);
  CHECK(run.wait().status == -SIGINT);
  CHECK(kill(std::stoi(process), 0) != 0);
  CHECK_FALSE(fs::exists(room.model()));
  fs::remove(slow);
  CHECK(done_before(printed(lumatlas_here(room.arguments()))) == "features matching ");
}

TEST_CASE("capture refuses places where its outputs would do harm") {
  const Surroundings room;
  const std::string inside = (room.photographs() / "model").string();
  check_failure(lumatlas_here({"capture", room.photographs().string(), "-o", inside}),
                "lies in the folder of the photographs");
  const TemporaryFolder other;
  (void)other.with_file("letter.txt", "dear");
  Arguments elsewhere = room.arguments();
  elsewhere.insert(elsewhere.end(), {"--work", other.path().string()});
  check_failure(lumatlas_here(elsewhere), "is in use, and not by `lumatlas capture`");
  check_failure(lumatlas_here({"capture", other.path().string(), "-o", room.model().string()}), "holds 0 photographs");
}

}  // namespace
}  // namespace lumatlas
