// SPDX-License-Identifier: GPL-3.0-or-later
// `lumatlas capture` with a stand-in for COLMAP: a script that says what COLMAP says and leaves a model that was made
// before, so that the whole way runs in seconds.
#include <signal.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"

namespace lumatlas {
namespace {

using nlohmann::json;

// Each command is noted in `calls`. A file `slow` makes the mapper wait for it to go away, `failing` makes it fail,
// `blind` makes it find nothing.
constexpr const char* kColmap = R"(#!/bin/sh
folder=$(dirname "$0")
command=$1
shift
if [ "$1" = -h ]; then
  echo '  --SiftExtraction.use_gpu arg (=1)'
  echo '  --SiftMatching.use_gpu arg (=1)'
  echo '  --ExhaustiveMatching.block_size arg (=50)'
  exit
fi
echo "$command $*" >> "$folder/calls"
while [ $# -gt 0 ]; do
  case $1 in
    --database_path) database=$2 ;;
    --output_path) output=$2 ;;
  esac
  shift 2
done
case $command in
  feature_extractor) 
    [ ! -f "$database" ] || : > "$folder/kept"
    echo "Processed file [12/12]"
    : > "$database" ;;
  exhaustive_matcher) echo "Matching block [1/1, 1/1]" ;;
  mapper)
    [ -f "$database" ] || exit 3
    if [ -f "$folder/failing" ]; then echo 'bundle adjustment lost its way' >&2; exit 4; fi
    if [ -f "$folder/blind" ]; then exit 0; fi
    echo 'Registering image #3 (7)'
    echo $$ > "$folder/at-work"
    while [ -f "$folder/slow" ]; do sleep 0.02; done
    cp -r "$folder/models/." "$output" ;;
esac
)";

// A folder of photographs, and a PATH whose `colmap` is the stand-in. The environment is as it was afterwards.
class Surroundings {
 public:
  explicit Surroundings(bool with_colmap = true) {
    fs::create_directory(bin_);
    fs::copy(made().scene + "/images", photographs_);
    fs::create_directories(bin_ / "models");
    fs::copy(made().scene + "/sparse", bin_ / "models" / "1", fs::copy_options::recursive);
    if (with_colmap) {
      std::ofstream(bin_ / "colmap") << kColmap;
      fs::permissions(bin_ / "colmap", fs::perms::owner_all);
    }
    setenv("PATH", (bin_.string() + (with_colmap ? ":" + before_ : "")).c_str(), 1);
  }
  ~Surroundings() { setenv("PATH", before_.c_str(), 1); }
  Surroundings(const Surroundings&) = delete;
  Surroundings& operator=(const Surroundings&) = delete;

  [[nodiscard]] Arguments arguments() const {
    return {"capture", photographs_.string(), "-o", model().string(), "--hold", "4", "--json"};
  }
  [[nodiscard]] fs::path model() const { return folder_ / "room"; }
  [[nodiscard]] fs::path work() const { return folder_ / "room-capture"; }
  [[nodiscard]] fs::path photographs() const { return photographs_; }
  [[nodiscard]] fs::path bin() const { return bin_; }
  [[nodiscard]] fs::path note(const char* name) const { return folder_.with_file("bin/" + std::string(name), "x"); }
  // The names of COLMAP's commands since the last call of this.
  [[nodiscard]] std::string calls() const {
    std::istringstream lines(bytes_of(bin_ / "calls"));
    fs::remove(bin_ / "calls");
    std::string names;
    for (std::string line; std::getline(lines, line);) names += line.substr(0, line.find(' ')) + ' ';
    return names;
  }

 private:
  TemporaryFolder folder_;
  std::string before_ = std::getenv("PATH");
  fs::path bin_ = folder_ / "bin", photographs_ = folder_ / "photographs";
};

constexpr const char* kAllCalls = "feature_extractor exhaustive_matcher mapper ";

// Which of the five steps were done before.
std::string done_before(const json& printed) {
  std::string done;
  for (const json& step : printed["steps"]) {
    if (step["done_before"]) done += step["name"].get<std::string>() + ' ';
  }
  return done;
}

json printed(const Outcome& outcome) {
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  return json::parse(outcome.out);
}

TEST_CASE("capture goes from photographs to a model, and its folder is a scene that validate reads") {
  const Surroundings room;
  const Outcome outcome = lumatlas_here(room.arguments());
  const json result = printed(outcome);
  CHECK(room.calls() == kAllCalls);
  CHECK(result["photographs"]["count"] == 12);
  CHECK(result["photographs"]["missed"].empty());
  CHECK(result["reconstructions"] == 1);
  CHECK(result["steps"].size() == 5);
  CHECK(done_before(result).empty());
  CHECK_THAT(outcome.err, Catch::Contains("step 3 of 5, mapping: poses and points") &&
                              Catch::Contains("12 of 12 photographs are placed") &&
                              Catch::Contains("taken as of one lens"));
  CHECK(json::parse(bytes_of(room.model() / "plan.json"))["summary"]["views"]["offered"] == 9);
  CHECK(fs::equivalent(room.work() / "images", room.photographs()));
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
  CHECK(result["reconstructions"] == 2);
  CHECK(result["photographs"]["count"] == 13);
  CHECK(result["photographs"]["missed"] == json{"0-of-nothing.png"});
  CHECK_THAT(outcome.err, Catch::Contains("12 of 13 photographs are placed, in the largest of 2 reconstructions") &&
                              Catch::Contains("without a place: 0-of-nothing.png"));
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
