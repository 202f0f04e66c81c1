// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs to capture, and a stand-in for COLMAP: a script that says what COLMAP says and leaves a model that was
// made before, so that the whole way runs in seconds.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"

namespace lumatlas::capturing {

using nlohmann::json;

// Each command is noted in `calls`, the photographs that features are looked for in `lists`, and the pairs that are
// compared besides in `links`. A file `database` becomes
// COLMAP's; `global` makes COLMAP have a global mapper; A file `slow` makes
// the mapper wait for it to go away, `failing` makes it fail, `blind` makes it find nothing; `featureless`, `matchless`
// and `pairless` make COLMAP say what it says in such cases.
inline constexpr const char* kColmap = R"sh(#!/bin/sh
folder=$(dirname "$0")
command=$1
shift
if [ "$1" = -h ]; then
  echo '  --SiftExtraction.use_gpu arg (=1)'
  echo '  --SiftMatching.use_gpu arg (=1)'
  echo '  --ExhaustiveMatching.block_size arg (=50)'
  exit
fi
if [ "$command" = help ]; then
  echo '  mapper'
  [ ! -f "$folder/global" ] || echo '  global_mapper'
  exit
fi
echo "$command $*" >> "$folder/calls"
while [ $# -gt 0 ]; do
  case $1 in
    --database_path) database=$2 ;;
    --output_path) output=$2 ;;
    --image_list_path) list=$2 ;;
    --match_list_path) cp "$2" "$folder/links" ;;
    --input_path) input=$2 ;;
  esac
  shift 2
done
case $command in
  feature_extractor) 
    [ ! -f "$database" ] || : > "$folder/kept"
    echo "$(tr '\n' ' ' < "$list")" >> "$folder/lists"
    echo "Processed file [12/12]"
    if [ -f "$folder/featureless" ]; then echo "  Features:        0"; else echo "  Features:        866"; fi
    if [ -f "$folder/database" ]; then cp "$folder/database" "$database"; else : > "$database"; fi ;;
  *_matcher|matches_importer) echo "Matching block [1/1, 1/1]" ;;
  point_triangulator) cp "$input"/* "$output" ;;
  mapper|global_mapper)
    [ -f "$database" ] || exit 3
    if [ -f "$folder/failing" ]; then echo 'bundle adjustment lost its way' >&2; exit 4; fi
    if [ -f "$folder/blind" ]; then exit 0; fi
    if [ -f "$folder/matchless" ]; then
      echo 'Loading images... 3 in 0.000s (connected 0)'
      echo 'WARNING: No images with matches found in the database.'
      echo 'ERROR: failed to create sparse model'
      exit 1
    fi
    if [ -f "$folder/pairless" ]; then
      echo '  => No good initial image pair found.'
      echo 'ERROR: failed to create sparse model'
      exit 1
    fi
    echo 'Registering image #3 (7)'
    echo $$ > "$folder/at-work"
    while [ -f "$folder/slow" ]; do sleep 0.02; done
    cp -r "$folder/models/." "$output" ;;
esac
)sh";

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

  // With a mesh of COLMAP's points, which takes next to no time.
  [[nodiscard]] Arguments arguments() const {
    return {"capture", photographs_.string(), "-o", model().string(), "--from", "points", "--hold", "4", "--json"};
  }
  [[nodiscard]] fs::path model() const { return folder_ / "room"; }
  [[nodiscard]] fs::path work() const { return folder_ / "room-capture"; }
  [[nodiscard]] fs::path photographs() const { return photographs_; }
  [[nodiscard]] fs::path folder() const { return folder_.path(); }
  [[nodiscard]] fs::path bin() const { return bin_; }
  [[nodiscard]] fs::path note(const char* name) const { return folder_.with_file("bin/" + std::string(name), "x"); }
  // Returns the names of the photographs, in order.
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names = names_in(photographs_);
    std::sort(names.begin(), names.end());
    return names;
  }
  // Returns the names of COLMAP's commands since the last call of this.
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

inline constexpr const char* kAllCalls = "feature_extractor exhaustive_matcher mapper ";

// Returns the names of the steps that were done before.
inline std::string done_before(const json& printed) {
  std::string done;
  for (const json& step : printed["steps"]) {
    if (step["done_before"]) done += step["name"].get<std::string>() + ' ';
  }
  return done;
}

inline json printed(const Outcome& outcome) {
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  return json::parse(outcome.out);
}

}  // namespace lumatlas::capturing
