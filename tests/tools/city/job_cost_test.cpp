// SPDX-License-Identifier: GPL-3.0-or-later
// What jobs of a city say that they took.
#include "tools/city/job_cost.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

TEST_CASE("a process counts its time, its memory and the bytes that it reads and writes", "[job_cost]") {
  const TemporaryFolder folder;
  const JobCost before = cost_of_this_process();
  constexpr std::size_t kBytes = 3'000'000;
  const auto file = folder.with_file("bytes", std::string(kBytes, 'x'));
  std::ostringstream read;
  read << std::ifstream(file, std::ios::binary).rdbuf();
  REQUIRE(read.str().size() == kBytes);
  double sum = 0;
  while (cost_of_this_process().processor_s < before.processor_s + 0.05) {
    for (int i = 0; i < 100'000; ++i) sum += std::sqrt(sum + i);
  }
  CHECK(sum > 0);
  const JobCost after = cost_of_this_process();
  CHECK(after.written_bytes - before.written_bytes >= kBytes);
  CHECK(after.written_bytes - before.written_bytes < 2 * kBytes);
  CHECK(after.read_bytes - before.read_bytes >= kBytes);
  CHECK(after.wall_s >= before.wall_s);
  CHECK(after.wall_s < 3600);
  CHECK(after.peak_bytes > kBytes);
  CHECK(after.peak_bytes < 64'000'000'000);
}

TEST_CASE("a job's cost is read back as it was written; none is there before", "[job_cost]") {
  const TemporaryFolder folder;
  const JobCost cost{1.5, 2.25, 3'000'000'000, 4, 5};
  CHECK_FALSE(read_job_cost(folder.path(), "7"));
  write_job_cost(folder.path(), "7", cost);
  CHECK(read_job_cost(folder.path(), "7") == cost);
  CHECK_FALSE(read_job_cost(folder.path(), "plan"));
}

TEST_CASE("a file that is no job's cost is refused by name, place and value", "[job_cost]") {
  using Catch::Matchers::Contains;
  const TemporaryFolder folder;
  write_job_cost(folder.path(), "join", {});
  const auto file = folder.path() / "costs" / "join.json";
  const auto sentence = [&](const std::string& text) -> std::string {
    std::ofstream(file) << text;
    try {
      (void)read_job_cost(folder.path(), "join");
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  const std::string rest = R"("wall_s": 1, "peak_bytes": 1, "read_bytes": 1, "written_bytes": 1})";
  CHECK(sentence(R"({"processor_s": 1, )" + rest) == "accepted");
  CHECK_THAT(sentence(R"({"processor_s": -1, )" + rest), Contains("join.json: processor_s: is below 0"));
  CHECK_THAT(sentence("{" + rest), Contains("join.json") && Contains("processor_s"));
  CHECK_THAT(sentence(R"({"processor_s": 1, "more": 1, )" + rest), Contains("more"));
  CHECK_THAT(sentence(R"({"processor_s": 1, "wall_s": 1, "peak_bytes": 0.5, "read_bytes": 1, "written_bytes": 1})"),
             Contains("peak_bytes"));
}

}  // namespace
}  // namespace lumatlas
