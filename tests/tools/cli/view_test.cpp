// SPDX-License-Identifier: GPL-3.0-or-later
// `lumatlas view` and `build --view` with mistakes in their arguments.
#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/tools/cli/program.h"
#include "tests/tools/cli/run_program.h"

namespace lumatlas {
namespace {

// Standard output is full, and what runs for longer than a minute is ended by a signal.
void fill_standard_output() {
  dup2(open("/dev/full", O_WRONLY | O_CLOEXEC), STDOUT_FILENO);
  alarm(60);
}

TEST_CASE("a page is not served where its address cannot be told") {
  const TemporaryFolder folder;
  for (const Arguments& arguments :
       {Arguments{"view", made().model, "--no-browser", "--quiet"},
        {"view", made().model, "--no-browser", "--quiet", "--json"},
        {"view", made().model, "--no-browser", "--quiet", "--follow"},
        {"build", made().scene, kLargeCells, "-o", (folder / "out").string(), "--view", "--no-browser", "--quiet"}}) {
    check_failure(lumatlas(arguments, fill_standard_output), "the page's address cannot be written");
  }
  CHECK(names_in(folder.path()).empty());
}

TEST_CASE("view refuses an empty host, which would be every address") {
  const Outcome outcome = lumatlas({"view", made().model, "--no-browser", "--host", ""}, [] { alarm(60); });
  CHECK(outcome.status == 2);
  CHECK(outcome.out.empty());
  CHECK_THAT(outcome.err, Catch::Contains("--host: is empty, must be a name or an address of this machine"));
}

TEST_CASE("view refuses a host that this machine is not") {
  check_failure(
      lumatlas({"view", made().model, "--no-browser", "--quiet", "--host", "no-such-host.invalid"}, [] { alarm(60); }),
      "no-such-host.invalid: cannot be listened at");
}

TEST_CASE("a page that is exported has the owner's file that stands beside the model") {
  const TemporaryFolder folder;
  std::filesystem::create_directory_symlink(made().model, folder / "room");
  (void)folder.with_file("room.page.json", R"({"title": "A room"})");
  const auto exported = [&](const char* output) {
    return lumatlas({"export", (folder / "room").string(), "--to", "web", "-o", (folder / output).string(), "--quiet"});
  };
  REQUIRE(exported("site").status == 0);
  CHECK_THAT(bytes_of(folder / "site" / "page.json"), Catch::Contains("A room"));
  CHECK_THAT(bytes_of(folder / "site" / "index.html"), Catch::Contains(" data-page-file=\"page.json\""));
  (void)folder.with_file("room.page.json", "{\"title\": ");
  check_failure(exported("page.html"), "room.page.json");
  CHECK_FALSE(std::filesystem::exists(folder / "page.html"));
}

}  // namespace
}  // namespace lumatlas
