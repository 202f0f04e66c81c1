// SPDX-License-Identifier: GPL-3.0-or-later
// A tiny synthetic scene and a model of it, which the tests of the program share.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"
#include "tests/tools/cli/run_program.h"

namespace lumatlas {

namespace fs = std::filesystem;

// The scene of all tests of this program, and a model of it built with --hold 4.
struct Made {
  TemporaryFolder folder;
  std::string scene = (folder / "scene").string();
  std::string model = (folder / "model").string();
  Outcome synth =
      lumatlas({"synth",    "apartment",    "-o",        scene,    "--photographs", "12",   "--width", "64",
                "--height", "48",           "--samples", "2",      "--triangles",   "3000", "--json",  "--path-frames",
                "3",        "--test-views", "2",         "--quiet"});
  Outcome build = lumatlas({"build", scene, kLargeCells, "-o", model, "--hold", "4", "--json", "--quiet"});
};

// Made at the first call.
const Made& made();

std::vector<std::string> names_in(const fs::path& folder);

// The options in effect that the program wrote beside an output.
nlohmann::json options_beside(const fs::path& output);

}  // namespace lumatlas
