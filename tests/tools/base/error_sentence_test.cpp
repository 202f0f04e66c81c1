// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/error_sentence.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "mesh/base/errors.h"
#include "mesh/base/pending_file.h"
#include "tests/support/temporary_folder.h"
#include "tools/base/output_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

class Silent : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return ""; }
};

TEST_CASE("an exception of any kind is told in a sentence that names something") {
  CHECK(error_sentence(InputError("a.png: no such file")) == "a.png: no such file");
  const std::error_code refused = std::make_error_code(std::errc::permission_denied);
  CHECK(error_sentence(fs::filesystem_error("cannot look", "/a", refused)) == "/a: cannot be used: Permission denied");
  CHECK(error_sentence(fs::filesystem_error("cannot move", "/a", "/b", refused)) ==
        "/a and /b: cannot be used: Permission denied");
  CHECK_THAT(error_sentence(std::bad_alloc()), Catch::StartsWith("out of memory"));
  CHECK_THAT(error_sentence(std::system_error(EAGAIN, std::generic_category())), Catch::StartsWith("no more threads"));
  CHECK_THAT(error_sentence(Silent()), Catch::Contains("Silent"));
}

TEST_CASE("a sentence about an output that is gone names it as the user did") {
  const TemporaryFolder folder;
  const fs::path target = folder / "model", file = folder / "model.ply";
  std::string inside, alone;
  {
    const OutputFolder output(target, "build");
    fs::create_directory(output.path() / "images");
    const PendingFile photograph(output.path() / "images" / "a.png");
    inside = photograph.path().string() + ": cannot be written; so is " + output.path().string();
    const PendingFile pending(file);
    alone = pending.path().string() + ": cannot be written";
  }
  CHECK(error_sentence(InputError(inside)) ==
        (target / "images/a.png").string() + ": cannot be written; so is " + target.string());
  CHECK(error_sentence(InputError(alone)) == file.string() + ": cannot be written");
}

}  // namespace
}  // namespace lumatlas
