// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/city_plan.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <numeric>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/city/small_city.h"
#include "tools/base/output_folder.h"
#include "tools/base/strict_json.h"

namespace lumatlas {

namespace {

const SmallCity& planned_city() {
  static const SmallCity city(6000);
  return city;
}

// Writes a plan with one value changed, and returns what reading it says.
std::string refusal_of_plan(const std::string& pointer, const nlohmann::json& value) {
  const SmallCity& city = planned_city();
  const TemporaryFolder changed;
  std::filesystem::copy(surface_folder(city.folder.path()), surface_folder(changed.path()),
                        std::filesystem::copy_options::recursive);
  nlohmann::json plan = read_json(city.folder / kPlanName);
  plan[nlohmann::json::json_pointer(pointer)] = value;
  write_json(changed / kPlanName, plan);
  try {
    (void)read_city_plan(changed.path());
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("A plan cuts the surface into blocks of whole cells, with all photographs that see each", "[city_plan]") {
  const CityPlan& plan = planned_city().plan;
  REQUIRE(plan.blocks.size() >= 5);
  CHECK(plan.views.size() == 16);
  CHECK(std::is_sorted(plan.views.begin(), plan.views.end(), [](auto& a, auto& b) { return a.name < b.name; }));
  CHECK(std::count_if(plan.blocks.begin(), plan.blocks.end(), [](const CityBlock& block) { return block.far; }) == 1);
  CHECK(plan.blocks.back().far);
  CHECK(plan.blocks.back().own_chunks == 0);
  std::size_t chunk = 0;
  for (std::size_t number = 0; number + 1 < plan.blocks.size(); ++number) {
    const CityBlock& block = plan.blocks[number];
    CHECK(block.size.faces <= 6000);
    CHECK(block.own_chunks >= 1);
    CHECK(block.chunks.size() >= block.own_chunks);
    CHECK(block.chunks.front() == chunk);
    chunk += block.own_chunks;
    CHECK(!block.views.empty());
    CHECK(std::is_sorted(block.views.begin(), block.views.end()));
  }
  CHECK(plan.blocks.back().chunks.size() == chunk);
}

TEST_CASE("A plan that was written is read back whole", "[city_plan]") {
  const SmallCity& city = planned_city();
  const CityPlan read = read_city_plan(city.folder.path());
  CHECK(read.scene == std::filesystem::absolute(small_city_scene()).lexically_normal());
  CHECK(read.stamp == city.plan.stamp);
  REQUIRE(read.georeference);
  CHECK(read.georeference == city.plan.georeference);
  CHECK(read.usual_distance == city.plan.usual_distance);
  CHECK(read.build.planner.visibility_px == 96);
  CHECK(read.build.max_views == city.plan.build.max_views);
  REQUIRE(read.views.size() == city.plan.views.size());
  for (std::size_t i = 0; i < read.views.size(); ++i) {
    const CityView &a = read.views[i], &b = city.plan.views[i];
    CHECK(a.name == b.name);
    CHECK(a.camera.cam_from_world_rotation == b.camera.cam_from_world_rotation);
    CHECK(a.camera.cam_from_world_translation == b.camera.cam_from_world_translation);
    CHECK(a.camera.fx == b.camera.fx);
    CHECK(a.gain == b.gain);
    CHECK(a.correction == b.correction);
    CHECK(a.motion == b.motion);
  }
  REQUIRE(read.blocks.size() == city.plan.blocks.size());
  for (std::size_t i = 0; i < read.blocks.size(); ++i) {
    CHECK(read.blocks[i].far == city.plan.blocks[i].far);
    CHECK(read.blocks[i].size.cells == city.plan.blocks[i].size.cells);
    CHECK(read.blocks[i].size.faces == city.plan.blocks[i].size.faces);
    CHECK(read.blocks[i].chunks == city.plan.blocks[i].chunks);
    CHECK(read.blocks[i].views == city.plan.blocks[i].views);
  }
}

TEST_CASE("A plan keeps how cameras moved while their shutters read", "[city_plan]") {
  const SmallCity& city = planned_city();
  const TemporaryFolder changed;
  std::filesystem::copy(surface_folder(city.folder.path()), surface_folder(changed.path()),
                        std::filesystem::copy_options::recursive);
  CityPlan plan = city.plan;
  plan.views.front().motion = {{0.01, 0.02, -0.03}, {0.1, -0.2, 0.3}};
  write_city_plan(changed.path(), plan);
  CHECK(read_city_plan(changed.path()).views.front().motion == plan.views.front().motion);
}

TEST_CASE("A plan that breaks a rule is refused by file, place and value", "[city_plan]") {
  using Catch::Matchers::Contains;
  CHECK_THAT(refusal_of_plan("/lumatlas_city", 99), Contains("plan.json") && Contains("another lumatlas"));
  CHECK_THAT(refusal_of_plan("/blocks/0/views/0", 16), Contains("blocks[0].views[0]"));
  CHECK_THAT(refusal_of_plan("/blocks/1/chunks/0", -1), Contains("blocks[1].chunks[0]"));
  CHECK_THAT(refusal_of_plan("/views/3/camera/focal/0", -5), Contains("views[3].camera") && Contains("fx"));
  CHECK_THAT(refusal_of_plan("/views/3/gain", nlohmann::json::array({1})), Contains("views[3].gain"));
  CHECK_THAT(refusal_of_plan("/usual_distance", 0), Contains("usual_distance"));
  CHECK_THAT(refusal_of_plan("/build/settings/planner.visibility", "large"),
             Contains("build") && Contains("planner.visibility"));
  CHECK_THAT(refusal_of_plan("/georeference/latitude", 91), Contains("georeference: is no georeference"));
  CHECK_THAT(refusal_of_plan("/extra", 1), Contains("extra"));
  CHECK_THROWS_WITH(read_city_plan(small_city_scene()), Contains("holds no plan that was finished"));
}

}  // namespace lumatlas
