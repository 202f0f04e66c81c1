// SPDX-License-Identifier: GPL-3.0-or-later
// The program as a user starts it, and a tiny synthetic scene with a model of it.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace lumatlas {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

struct Outcome {
  int status = 0;  // exit status, or minus the signal that ended it
  std::string out;
  std::string err;
};

// The program while it runs, its streams going to files in a folder of its own.
class Run {
 public:
  explicit Run(Arguments arguments);
  void interrupt() const;
  [[nodiscard]] std::string out() const;  // that it has printed so far
  [[nodiscard]] Outcome wait() const;

 private:
  TemporaryFolder streams_;
  pid_t child_ = -1;
};

// Runs it to its end, and checks that no signal ended it.
Outcome lumatlas(const Arguments& arguments);

// Checks that it failed with one sentence, which starts as every failure does and has this part.
void check_failure(const Outcome& outcome, const std::string& part);

// The scene of all tests of this program, and a model of it built with --hold 4.
struct Made {
  TemporaryFolder folder;
  std::string scene = (folder / "scene").string();
  std::string model = (folder / "model").string();
  Outcome synth =
      lumatlas({"synth",    "apartment",    "-o",        scene,    "--photographs", "12",   "--width", "64",
                "--height", "48",           "--samples", "2",      "--triangles",   "3000", "--json",  "--path-frames",
                "3",        "--test-views", "2",         "--quiet"});
  Outcome build = lumatlas({"build", scene, "-o", model, "--hold", "4", "--json", "--quiet"});
};

// Made at the first call.
const Made& made();

std::vector<std::string> names_in(const fs::path& folder);

// The options in effect that the program wrote beside an output.
nlohmann::json options_beside(const fs::path& output);

}  // namespace lumatlas
