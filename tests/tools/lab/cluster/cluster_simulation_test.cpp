// SPDX-License-Identifier: GPL-3.0-or-later
// Cities whose time on a cluster is known on paper.
#include "tools/lab/cluster/cluster_simulation.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace lumatlas {
namespace {

constexpr double kFast = 1e30;  // of a disk, bytes a second

ClusterJob computing(double seconds) {
  return {seconds, 0, 0, 0};
}

ClusterCity computing_city() {
  return {computing(3), computing(5), {computing(1), computing(4), computing(2), computing(6)}};
}

double gain_of(const std::vector<ClusterBound>& bounds, const std::string& name) {
  const auto found = std::find_if(bounds.begin(), bounds.end(), [&](auto& bound) { return bound.name == name; });
  REQUIRE(found != bounds.end());
  return found->gain_s;
}

TEST_CASE("one core takes the sum of all jobs") {
  const ClusterRun run = simulated_run(computing_city(), {1, 1, 1, kFast});
  CHECK(run.plan_s == Approx(3));
  CHECK(run.blocks_s == Approx(13));
  CHECK(run.total_s() == Approx(21));
}

TEST_CASE("machines without end take the plan, the longest block and the join") {
  for (const Cluster& cluster : {Cluster{1000, 1, 1, kFast}, Cluster{1, 1000, 1, kFast}, Cluster{2, 2, 1, kFast}}) {
    CHECK(simulated_run(computing_city(), cluster).total_s() == Approx(3 + 6 + 5));
  }
}

TEST_CASE("jobs begin in their order, each on the first free core") {
  // Two cores: 1 and 4 begin; 2 begins at 1, 6 at 3 and ends at 9.
  CHECK(simulated_run(computing_city(), {1, 2, 1, kFast}).blocks_s == Approx(9));
  CHECK(simulated_run(computing_city(), {2, 1, 1, kFast}).blocks_s == Approx(9));
}

TEST_CASE("a disk that all share takes all bytes over its speed, however many machines there are") {
  ClusterCity city;
  city.plan = {0, 0, 100, 50};
  city.join = {0, 0, 20, 30};
  for (int block = 0; block < 8; ++block) city.blocks.push_back({0, 0, 30, 10});
  for (const std::size_t machines : {1, 3, 100}) {
    const ClusterRun run = simulated_run(city, {machines, 2, 1, 10});
    CHECK(run.plan_s == Approx(15));
    CHECK(run.blocks_s == Approx(32));
    CHECK(run.join_s == Approx(5));
  }
  CHECK(bounds_of(city, {100, 2, 1, 10}).front().name == "disk");
  CHECK(gain_of(bounds_of(city, {100, 2, 1, 10}), "disk") == Approx(52));
}

TEST_CASE("a job computes while others read, and shares the disk only with those that use it") {
  // Both read 10 bytes at half speed until 2; then A computes 3 until 5, B writes 20 bytes alone until 4.
  ClusterCity city;
  city.blocks = {{3, 0, 10, 0}, {0, 0, 10, 20}};
  CHECK(simulated_run(city, {1, 2, 1, 10}).blocks_s == Approx(5));
  // C reads 30 bytes: A, B and C until 3 (10 each), then C has 20 left and has the disk alone until 5.
  city.blocks = {{1, 0, 10, 0}, {1, 0, 10, 0}, {0, 0, 30, 0}};
  CHECK(simulated_run(city, {3, 1, 1, 10}).blocks_s == Approx(5));
}

TEST_CASE("a machine runs no more jobs than it has memory for") {
  ClusterCity city;
  city.blocks = {{4, 3, 0, 0}, {4, 3, 0, 0}, {4, 1, 0, 0}};
  // 4 bytes: the first and the third run together, then the second.
  CHECK(simulated_run(city, {1, 3, 4, kFast}).blocks_s == Approx(8));
  CHECK(simulated_run(city, {1, 3, 7, kFast}).blocks_s == Approx(4));
  CHECK(gain_of(bounds_of(city, {1, 3, 4, kFast}), "memory") == Approx(4));
  CHECK_THROWS_WITH(simulated_run(city, {1, 3, 2, kFast}), Catch::StartsWith("block 0 takes 0.0 GB of memory"));
  city.join.peak_bytes = 9e9;
  CHECK_THROWS_WITH(simulated_run(city, {1, 3, 8e9, kFast}), "the join takes 9.0 GB of memory, a machine has 8.0 GB");
}

TEST_CASE("what limits first is what costs most") {
  const Cluster few{1, 1, 1, kFast}, many{100, 1, 1, kFast};
  CHECK(bounds_of(computing_city(), few).front().name == "processors");
  CHECK(gain_of(bounds_of(computing_city(), few), "processors") == Approx(7));
  CHECK(bounds_of(computing_city(), many).front().name == "join");
  CHECK(gain_of(bounds_of(computing_city(), many), "join") == Approx(5));
  CHECK(gain_of(bounds_of(computing_city(), many), "plan") == Approx(3));
  CHECK(gain_of(bounds_of(computing_city(), many), "longest block") == Approx(2));  // 6 becomes 3.25, then 4 is longest
  CHECK(gain_of(bounds_of(computing_city(), many), "processors") == 0);
}

TEST_CASE("a city without blocks, and clusters that are none") {
  CHECK(simulated_run({computing(1), computing(2), {}}, {1, 1, 1, 1}).total_s() == Approx(3));
  CHECK_THROWS_AS(simulated_run({}, {0, 1, 1, 1}), std::invalid_argument);
  CHECK_THROWS_AS(simulated_run({}, {1, 0, 1, 1}), std::invalid_argument);
  CHECK_THROWS_AS(simulated_run({}, {1, 1, 0, 1}), std::invalid_argument);
  CHECK_THROWS_AS(simulated_run({}, {1, 1, 1, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
