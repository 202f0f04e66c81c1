// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/block_jobs.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/tools/city/small_city.h"
#include "tests/tools/cli/run_program.h"
#include "tools/city/block_job.h"
#include "tools/city/job_cost.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

const fs::path kProgram = LUMATLAS_PROGRAM;

Arguments city_arguments(const fs::path& scene, const fs::path& model, int jobs) {
  return {"city",   scene.string(),      "-o", model.string(), "--as-posed",  "--block-faces",
          "5000",   "--texture",         "0",  "--quiet",      "--cell-size", "4",
          "--jobs", std::to_string(jobs)};
}

void copy_scene(const fs::path& to) {
  fs::copy(small_city_scene(), to, fs::copy_options::recursive);
}

// Returns when each block that is done was finished.
std::map<std::string, fs::file_time_type> done_in(const fs::path& plan) {
  std::map<std::string, fs::file_time_type> done;
  std::error_code error;
  for (fs::directory_iterator entry(plan / "blocks", error), end; !error && entry != end; entry.increment(error)) {
    std::error_code missing;
    if (entry->path().filename().string().front() == '.') continue;  // a block that was killed before its rename
    const fs::file_time_type time = fs::last_write_time(entry->path() / "lumatlas.json", missing);
    if (!missing) done[entry->path().filename().string()] = time;
  }
  return done;
}

void check_misuse(const Arguments& arguments, const std::string& part) {
  const Outcome outcome = lumatlas(arguments);
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.err, Catch::Matchers::Contains(part));
}

}  // namespace

TEST_CASE("A city is the same bytes for any number of jobs", "[block_jobs]") {
  const TemporaryFolder folder;
  REQUIRE(lumatlas(city_arguments(small_city_scene(), folder / "one", 1)).status == 0);
  REQUIRE(lumatlas(city_arguments(small_city_scene(), folder / "three", 3)).status == 0);
  const auto one = files_of(folder / "one");
  CHECK(one.contains("tileset.json"));
  CHECK(one == files_of(folder / "three"));
  CHECK(!fs::exists(folder / "one.city"));
}

TEST_CASE("A city goes on from the blocks that were done when it was killed", "[block_jobs]") {
  const TemporaryFolder folder;
  REQUIRE(lumatlas(city_arguments(small_city_scene(), folder / "whole", 2)).status == 0);
  const fs::path model = folder / "model", plan = folder / "model.city";
  for (const int signal : {SIGKILL, SIGINT}) {
    const auto before = done_in(plan);
    const Run run(city_arguments(small_city_scene(), model, 2));
    Run::wait_until([&] { return done_in(plan).size() > before.size() || run.has_ended(); });
    run.send(signal);
    CHECK(run.wait().status == -signal);
    CHECK(!fs::exists(model));
    const auto after = done_in(plan);
    CHECK(after.size() > before.size());
    for (const auto& [block, time] : before) CHECK(after.at(block) == time);  // it was not made again
  }
  REQUIRE(lumatlas(city_arguments(small_city_scene(), model, 2)).status == 0);
  CHECK(files_of(model) == files_of(folder / "whole"));
}

TEST_CASE("A block that fails is named, the others go on, and the next call makes what is missing", "[block_jobs]") {
  const TemporaryFolder folder;
  const fs::path scene = folder / "scene", model = folder / "model";
  copy_scene(scene);
  Arguments planning = city_arguments(scene, model, 2);
  planning[2] = "--plan";
  REQUIRE(lumatlas(planning).status == 0);
  // A photograph is damaged once the city was planned.
  const CityPlan plan = read_city_plan(model);
  std::vector<std::size_t> seen_by(plan.views.size(), 0);
  for (const CityBlock& block : plan.blocks) {
    for (const std::size_t view : block.views) ++seen_by[view];
  }
  const auto rarest = static_cast<std::size_t>(std::min_element(seen_by.begin(), seen_by.end()) - seen_by.begin());
  REQUIRE(seen_by[rarest] < plan.blocks.size());
  const fs::path photograph = scene / "images" / plan.views[rarest].name;
  const std::string bytes = bytes_of(photograph);
  std::ofstream(photograph, std::ios::binary | std::ios::trunc) << bytes.substr(0, bytes.size() / 2);
  const std::vector<FailedBlock> failed = run_block_jobs(kProgram, model, plan, 2, {});
  REQUIRE(!failed.empty());
  CHECK(failed.size() <= seen_by[rarest]);
  CHECK_THAT(failed.front().why, Catch::Matchers::Contains(plan.views[rarest].name));
  CHECK(done_in(model).size() == plan.blocks.size() - failed.size());
  std::ofstream(photograph, std::ios::binary | std::ios::trunc) << bytes;
  CHECK(run_block_jobs(kProgram, model, plan, 2, {}).empty());
  CHECK(done_in(model).size() == plan.blocks.size());
}

TEST_CASE("Each job of a plan says what it took", "[block_jobs]") {
  const TemporaryFolder folder;
  const fs::path plan = folder / "plan";
  Arguments planning = city_arguments(small_city_scene(), plan, 1);
  planning[2] = "--plan";
  REQUIRE(lumatlas(planning).status == 0);
  CHECK(read_job_cost(plan, "plan"));
  CHECK_FALSE(read_job_cost(plan, "join"));
  REQUIRE(lumatlas({"city", plan.string(), "-o", (folder / "model").string(), "--texture", "0", "--quiet"}).status ==
          0);
  std::vector<std::string> jobs{"plan", "join"};
  for (std::size_t block = 0; block < read_city_plan(plan).blocks.size(); ++block)
    jobs.push_back(std::to_string(block));
  CHECK(jobs.size() > 5);
  for (const std::string& job : jobs) {
    CAPTURE(job);
    const std::optional<JobCost> cost = read_job_cost(plan, job);
    REQUIRE(cost);
    CHECK(cost->processor_s > 0);
    CHECK(cost->peak_bytes > 1'000'000);
    CHECK(cost->read_bytes > 1000);
    CHECK(cost->written_bytes > 1000);
  }
}

TEST_CASE("Options that do not go together are refused before any work", "[block_jobs]") {
  const TemporaryFolder folder;
  const std::string scene = small_city_scene().string(), plan = (folder / "plan").string();
  check_misuse({"city", scene, "--job", "0"}, "is no plan that was finished");
  check_misuse({"city", scene}, "give one of --output, --plan and --job");
  Arguments planning = city_arguments(scene, plan, 1);
  planning[2] = "--plan";
  REQUIRE(lumatlas(planning).status == 0);
  CHECK(fs::exists(folder / "plan/Snakefile"));
  check_misuse({"city", plan, "-o", (folder / "m").string(), "--block-faces", "9000"}, "--block-faces");
  check_misuse({"city", plan, "--job", "99"}, "99 must be below the plan's");
  planning.push_back("--max-views=7");
  check_failure(lumatlas(planning), "is the plan of other inputs or options");
}

}  // namespace lumatlas
