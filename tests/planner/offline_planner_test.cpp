// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/offline_planner.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <numeric>
#include <random>

#include "planner/coverage/coverage_ledger.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

using Views = std::vector<std::vector<CellPart>>;
using Choice = std::vector<std::uint32_t>;

const Surface& room() {
  static const std::shared_ptr<const Surface> surface = room_surface();
  return *surface;
}

OfflineOptions offline_options(CoverageOptions::Metric metric) {
  OfflineOptions options;
  options.coverage.metric = metric;
  options.coverage.ideal_distance = 2;
  options.coverage.max_references = 3;
  return options;
}

// Each view sees about half of `cells` cells, from anywhere in front of them, more or less well.
Views random_views(std::mt19937& random, std::size_t count, std::uint32_t cells) {
  std::uniform_real_distribution<double> uniform(0, 1);
  Views views(count);
  for (std::vector<CellPart>& view : views) {
    for (CellId cell{0}; cell < cells; ++cell) {
      if (uniform(random) < 0.5) continue;
      const glm::dvec3 anywhere(uniform(random) - 0.5, uniform(random) - 0.5, uniform(random) - 0.5);
      const glm::dvec3 direction = glm::normalize(room().cells.cells[cell].normal + 2.0 * anywhere);
      const double distance = 1 + 2 * uniform(random), cell_share = uniform(random);
      const double positional = positional_coverage(distance, cell_share, 2, {});
      view.push_back({CellId{cell}, {direction, positional, distance, cell_share, 0.1 * uniform(random)}});
    }
  }
  return views;
}

double coverage_of(const Views& views, const Choice& choice, const OfflineOptions& options) {
  CoverageLedger ledger(room(), static_cast<std::uint32_t>(choice.size()), options.coverage,
                        options.min_reference_gain);
  for (const std::vector<CellPart>& view : views) ledger.add_demand(view);
  for (ViewSlot slot{0}; slot < choice.size(); ++slot) ledger.insert(slot, views[choice[slot]]);
  return ledger.summed_coverage();
}

// Calls `visit` with every choice of `count` of `of` views.
void for_each_choice(std::uint32_t of, std::size_t count, const std::function<void(const Choice&)>& visit) {
  for (std::uint32_t bits = 0; bits < 1u << of; ++bits) {
    Choice choice;
    for (std::uint32_t view = 0; view < of; ++view) {
      if (bits >> view & 1) choice.push_back(view);
    }
    if (choice.size() == count) visit(choice);
  }
}

// The first of the views that add most, one after the other, each time by asking them all.
Choice plain_greedy(const Views& views, std::size_t count, const OfflineOptions& options) {
  CoverageLedger ledger(room(), static_cast<std::uint32_t>(count), options.coverage, options.min_reference_gain);
  for (const std::vector<CellPart>& view : views) ledger.add_demand(view);
  Choice choice;
  while (choice.size() < count) {
    std::uint32_t best = 0;
    double most = -1;
    for (std::uint32_t view = 0; view < views.size(); ++view) {
      if (std::find(choice.begin(), choice.end(), view) != choice.end()) continue;
      const double gain = ledger.gain(views[view]);
      if (gain > most) {
        most = gain;
        best = view;
      }
    }
    ledger.insert(ViewSlot(static_cast<std::uint32_t>(choice.size())), views[best]);
    choice.push_back(best);
  }
  std::sort(choice.begin(), choice.end());
  return choice;
}

// Sums of a few hundred terms of order one, in another order.
constexpr double kDoubleRounding = 1e-9;

TEST_CASE(
    "of a submodular measure the offline choice is worth what greedy selection promises, and never beats the best") {
  std::mt19937 random(11);
  const OfflineOptions options = offline_options(CoverageOptions::Metric::directions);
  double worst = 1;
  for (int round = 0; round < 30; ++round) {
    const Views views = random_views(random, 9, 6);
    const std::uint32_t count = 1 + round % 5;
    double best = 0;
    for_each_choice(9, count,
                    [&](const Choice& choice) { best = std::max(best, coverage_of(views, choice, options)); });
    const OfflineChoice offline = plan_offline(room(), views, count, options);
    CHECK(offline.views.size() == count);
    CHECK(offline.greedy_coverage >= (1 - std::exp(-1.0)) * best);
    CHECK(offline.summed_coverage >= offline.greedy_coverage);
    CHECK(offline.summed_coverage <= best + kDoubleRounding);
    if (count == 1) CHECK(offline.summed_coverage == Approx(best).margin(kDoubleRounding));
    worst = std::min(worst, offline.summed_coverage / best);
  }
  CHECK(worst > 0.9);  // random instances are kind; no theorem says so
}

TEST_CASE("the coverage that the offline planner reports is that of the views that it names") {
  const auto metric = GENERATE(CoverageOptions::Metric::directions, CoverageOptions::Metric::paper);
  std::mt19937 random(12);
  const OfflineOptions options = offline_options(metric);
  for (int round = 0; round < 10; ++round) {
    const Views views = random_views(random, 30, 10);
    const OfflineChoice offline = plan_offline(room(), views, 8, options);
    CHECK(std::is_sorted(offline.views.begin(), offline.views.end()));
    CHECK(std::adjacent_find(offline.views.begin(), offline.views.end()) == offline.views.end());
    CHECK(offline.summed_coverage >= offline.greedy_coverage);
    if (metric == CoverageOptions::Metric::paper) continue;  // depends on the order of arrival
    CHECK(offline.summed_coverage == Approx(coverage_of(views, offline.views, options)).margin(kDoubleRounding));
  }
}

TEST_CASE("once the exchanges rest, no exchange of one view against another raises the coverage") {
  std::mt19937 random(13);
  const OfflineOptions options = offline_options(CoverageOptions::Metric::directions);
  std::size_t exchanged = 0;
  for (int round = 0; round < 10; ++round) {
    const Views views = random_views(random, 24, 8);
    const OfflineChoice offline = plan_offline(room(), views, 6, options);
    REQUIRE_FALSE(offline.exchanges.empty());
    REQUIRE(offline.exchanges.back() == 0);
    for (const std::size_t count : offline.exchanges) exchanged += count;
    for (std::size_t out = 0; out < offline.views.size(); ++out) {
      for (std::uint32_t in = 0; in < views.size(); ++in) {
        if (std::binary_search(offline.views.begin(), offline.views.end(), in)) continue;
        Choice other = offline.views;
        other[out] = in;
        CHECK(coverage_of(views, other, options) <= offline.summed_coverage * (1 + kDoubleRounding));
      }
    }
  }
  CHECK(exchanged > 0);  // else the passes were not tested
}

TEST_CASE("lazy evaluation chooses what plain greedy selection does, and asks less") {
  std::mt19937 random(14);
  OfflineOptions options = offline_options(CoverageOptions::Metric::directions);
  options.max_passes = 0;
  for (int round = 0; round < 10; ++round) {
    const Views views = random_views(random, 60, 12);
    const std::uint32_t count = 15;
    const OfflineChoice offline = plan_offline(room(), views, count, options);
    CHECK(offline.views == plain_greedy(views, count, options));
    CHECK(offline.exchanges.empty());
    CHECK(offline.summed_coverage == offline.greedy_coverage);
    CHECK(offline.evaluations < 60 * count / 2);
  }
}

TEST_CASE("the offline choice is the same on one thread as on many, and of equals the first is chosen") {
  const auto metric = GENERATE(CoverageOptions::Metric::directions, CoverageOptions::Metric::paper);
  std::mt19937 random(15);
  const OfflineOptions options = offline_options(metric);
  Views views = random_views(random, 40, 300);
  views.insert(views.end(), views.begin(), views.begin() + 40);  // each twice
  const OfflineChoice many = plan_offline(room(), views, 12, options);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const OfflineChoice one = plan_offline(room(), views, 12, options);
  CHECK(one.views == many.views);
  CHECK(one.summed_coverage == many.summed_coverage);
  const OfflineChoice single = plan_offline(room(), views, 1, options);
  REQUIRE(single.views.size() == 1);
  CHECK(single.views.front() < 40);
}

TEST_CASE("planning offline calls its cancel check at each view, and what that throws ends it") {
  std::mt19937 random(17);
  OfflineOptions options = offline_options(CoverageOptions::Metric::directions);
  const Views views = random_views(random, 20, 50);
  std::size_t calls = 0;
  options.cancel_check = [&] { ++calls; };
  const OfflineChoice choice = plan_offline(room(), views, 4, options);
  // Each view asks and is evaluated, and those that are not chosen are tried again in each pass.
  CHECK(calls == 20 + choice.evaluations + 16 * choice.exchanges.size());
  for (std::size_t last = 1; last <= calls; last += 7) {
    std::size_t now = 0;
    options.cancel_check = [&] {
      if (++now == last) throw std::runtime_error("enough");
    };
    CHECK_THROWS_WITH(plan_offline(room(), views, 4, options), "enough");
    CHECK(now == last);
  }
}

TEST_CASE("with room for all, every view that adds something is chosen, and none that sees nothing") {
  std::mt19937 random(16);
  const OfflineOptions options = offline_options(CoverageOptions::Metric::directions);
  Views views = random_views(random, 5, 8);
  views.insert(views.begin() + 2, std::vector<CellPart>{});
  CHECK(plan_offline(room(), views, 6, options).views == Choice{0, 1, 3, 4, 5});
  CHECK(plan_offline(room(), views, 1000, options).views == Choice{0, 1, 3, 4, 5});
  CHECK(plan_offline(room(), Views(3), 2, options).views.empty());
  CHECK(plan_offline(room(), {}, 2, options).views.empty());
}

TEST_CASE("an offline choice of no view, or by options that break a rule, is refused") {
  OfflineOptions options = offline_options(CoverageOptions::Metric::directions);
  CHECK_THROWS_WITH(plan_offline(room(), {}, 0, options), "offline planner: count is 0, must be at least 1");
  options.coverage.lambda = 2;
  CHECK_THROWS_WITH(plan_offline(room(), {}, 1, options), Catch::Contains("lambda"));
  options = offline_options(CoverageOptions::Metric::directions);
  for (const double gain : {-0.1, std::numeric_limits<double>::quiet_NaN()}) {
    options.min_reference_gain = gain;
    CHECK_THROWS_WITH(plan_offline(room(), {}, 1, options), Catch::Contains("min_reference_gain is "));
  }
}

}  // namespace
}  // namespace lumatlas
