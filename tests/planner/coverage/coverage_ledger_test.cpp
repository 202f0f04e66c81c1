// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/coverage_ledger.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <glm/glm.hpp>
#include <random>
#include <set>

#include "planner/coverage/direction_coverage.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

using Metric = CoverageOptions::Metric;

constexpr std::uint32_t kSlots = 9;
constexpr double kMinReferenceGain = 0.001;

CoverageOptions options_of(Metric metric) {
  CoverageOptions options;
  options.metric = metric;
  options.ideal_distance = 2;
  options.max_references = 4;
  return options;
}

CoverageOptions printed() {
  CoverageOptions options = CoverageOptions::printed();
  options.ideal_distance = 2;
  options.max_references = 4;
  return options;
}

// A view that sees a random half of the room's cells from random directions and distances, more or less of them.
std::vector<CellPart> random_half(std::mt19937& random, const Surface& surface) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<CellPart> parts;
  for (CellId cell{0}; cell < surface.cells.cells.size(); ++cell) {
    if (random() % 2 == 0) continue;
    const glm::dvec3 towards = 1.5 * surface.cells.cells[cell].normal;
    const glm::dvec3 direction(uniform(random), uniform(random), uniform(random));
    const double cell_share = 0.5 + 0.5 * uniform(random);
    const double distance = 2 + uniform(random);
    const double picture_share = 0.1 * (1 + uniform(random));
    const double positional = positional_coverage(distance, cell_share, 2, {});
    parts.push_back(
        {CellId{cell}, {glm::normalize(direction + towards), positional, distance, cell_share, picture_share}});
  }
  return parts;
}

struct Ledger {
  explicit Ledger(const CoverageOptions& options) : ledger(*surface, kSlots, options, kMinReferenceGain) {}
  // A view that is offered; it may be stored or not.
  std::vector<CellPart> offered() {
    asked.push_back(random_half(random, *surface));
    ledger.add_demand(asked.back());
    return asked.back();
  }
  std::vector<ViewSlot> stored() const {
    std::vector<ViewSlot> slots;
    for (ViewSlot slot{0}; slot < kSlots; ++slot) {
      if (ledger.stored(slot)) slots.push_back(slot);
    }
    return slots;
  }

  std::shared_ptr<const Surface> surface = room_surface();
  std::mt19937 random{17};
  std::vector<std::vector<CellPart>> asked;
  CoverageLedger ledger;
};

// A random insertion or eviction; as many views are offered and not stored, and some of these taken back.
void step(Ledger& scene) {
  if (scene.random() % 2 == 0) scene.offered();
  if (scene.random() % 4 == 0 && !scene.asked.empty()) {
    std::swap(scene.asked[scene.random() % scene.asked.size()], scene.asked.back());
    scene.ledger.remove_demand(scene.asked.back());
    scene.asked.pop_back();
  }
  const ViewSlot slot(static_cast<std::uint32_t>(scene.random() % kSlots));
  if (scene.ledger.stored(slot)) {
    scene.ledger.erase(slot);
  } else {
    scene.ledger.insert(slot, scene.offered());
  }
}

void check_against_scratch(const Ledger& scene, const CoverageOptions& options) {
  // A ledger that never saw the views that have left. References depend on the history, so only what does not depend on
  // them is compared for the paper's metric through value_by_definition below.
  CoverageLedger fresh(*scene.surface, kSlots, options, kMinReferenceGain);
  std::for_each(scene.asked.rbegin(), scene.asked.rend(), [&](const auto& parts) { fresh.add_demand(parts); });
  for (const ViewSlot slot : scene.stored()) {
    fresh.insert(slot, {scene.ledger.parts(slot).begin(), scene.ledger.parts(slot).end()});
  }
  CHECK(scene.ledger.summed_coverage() == Approx(fresh.summed_coverage()).margin(1e-6));
  for (const ViewSlot slot : scene.stored()) {
    CHECK(scene.ledger.loss(slot) == Approx(fresh.loss(slot)).margin(1e-6));
  }
}

TEST_CASE("the running sums equal those of a ledger filled anew, after hundreds of insertions and evictions") {
  const CoverageOptions options = options_of(Metric::directions);
  Ledger scene(options);
  for (int i = 0; i < 600; ++i) {
    step(scene);
    if (i % 40 == 39) check_against_scratch(scene, options);
  }
}

TEST_CASE("whatever is kept up equals its definition, after hundreds of insertions and evictions") {
  const std::vector<CoverageOptions> all{options_of(Metric::directions), options_of(Metric::paper), printed()};
  for (const CoverageOptions& options : all) {
    Ledger scene(options);
    for (int i = 0; i < 400; ++i) {
      step(scene);
      if (i % 50 != 49) continue;
      double sum = 0;
      for (CellId cell{0}; cell < scene.surface->cells.cells.size(); ++cell) sum += scene.ledger.coverage(cell);
      CHECK(scene.ledger.summed_coverage() == Approx(sum).margin(1e-9));
      const std::vector<CellPart> nothing;
      for (const ViewSlot slot : scene.stored()) {
        const std::vector<ViewSlot> gone{slot};
        CHECK(scene.ledger.loss(slot) == Approx(-scene.ledger.joint_exchange_gain(nothing, gone)).margin(1e-9));
      }
    }
  }
}

TEST_CASE("a view whose parts are replaced counts as if it had been inserted with them, and so does its demand") {
  for (const CoverageOptions& options : {options_of(Metric::directions), options_of(Metric::paper)}) {
    Ledger scene(options);
    for (ViewSlot slot{0}; slot < kSlots; ++slot) scene.ledger.insert(slot, scene.offered());
    for (int round = 0; round < 60; ++round) {
      const ViewSlot slot(static_cast<std::uint32_t>(scene.random() % kSlots));
      const std::span<const CellPart> now = scene.ledger.parts(slot);
      const std::vector<CellPart> before(now.begin(), now.end());
      std::vector<std::uint8_t> kept(scene.ledger.cells());
      for (std::uint8_t& keeps : kept) keeps = scene.random() % 8 != 0;
      // Cells that are not kept come again or not, some others are seen otherwise, and new ones come.
      std::vector<CellPart> after = random_half(scene.random, *scene.surface);
      for (CellPart& entry : after) {
        const auto old =
            std::find_if(before.begin(), before.end(), [&](const auto& e) { return e.cell == entry.cell; });
        if (old != before.end() && scene.random() % 4 != 0) entry = *old;
      }
      scene.ledger.keep_cells(slot, kept);
      CHECK(std::none_of(scene.ledger.parts(slot).begin(), scene.ledger.parts(slot).end(),
                         [&](const CellPart& entry) { return kept[entry.cell] == 0; }));
      scene.ledger.replace(slot, after);
      CHECK(std::equal(after.begin(), after.end(), scene.ledger.parts(slot).begin(), scene.ledger.parts(slot).end(),
                       [](const auto& a, const auto& b) { return a.cell == b.cell && a.part == b.part; }));
      const auto asked = std::find_if(scene.asked.begin(), scene.asked.end(), [&](const auto& parts) {
        return std::equal(parts.begin(), parts.end(), before.begin(), before.end(),
                          [](const auto& a, const auto& b) { return a.cell == b.cell && a.part == b.part; });
      });
      REQUIRE(asked != scene.asked.end());
      *asked = after;
    }
    if (options.metric == Metric::directions) check_against_scratch(scene, options);
    double sum = 0;
    for (CellId cell{0}; cell < scene.ledger.cells(); ++cell) sum += scene.ledger.coverage(cell);
    CHECK(scene.ledger.summed_coverage() == Approx(sum).margin(1e-9));
    for (ViewSlot slot{0}; slot < kSlots; ++slot) {
      const std::vector<ViewSlot> gone{slot};
      CHECK(scene.ledger.loss(slot) == Approx(-scene.ledger.joint_exchange_gain({}, gone)).margin(1e-9));
    }
  }
}

TEST_CASE("a copy of a ledger says the same, has more slots, and changes alone") {
  for (const CoverageOptions& options : {options_of(Metric::directions), options_of(Metric::paper)}) {
    Ledger scene(options);
    for (int i = 0; i < 60; ++i) step(scene);
    CoverageLedger copy(scene.ledger, 2);
    CHECK(copy.slots() == kSlots + 2);
    const double before = scene.ledger.summed_coverage();
    CHECK(copy.summed_coverage() == before);
    const std::vector<CellPart> more = random_half(scene.random, *scene.surface);
    CHECK(copy.gain(more) == scene.ledger.gain(more));
    copy.insert(ViewSlot{kSlots + 1}, more);
    CHECK(copy.summed_coverage() == Approx(before + scene.ledger.gain(more)));
    CHECK(scene.ledger.summed_coverage() == before);
    copy.erase(ViewSlot{kSlots + 1});
    if (options.metric == Metric::directions) CHECK(copy.summed_coverage() == Approx(before));  // whatever the history
  }
}

TEST_CASE("a copy of a ledger decides as the ledger does, though it knows no references") {
  for (const CoverageOptions& options : {options_of(Metric::directions), options_of(Metric::paper), printed()}) {
    Ledger scene(options);
    for (int i = 0; i < 30; ++i) step(scene);
    CoverageLedger copy(scene.ledger, 0);
    for (int round = 0; round < 60; ++round) {
      const std::vector<CellPart> parts = scene.offered();
      copy.add_demand(parts);
      CHECK(copy.gain(parts) == scene.ledger.gain(parts));
      CHECK(copy.exchange_gains(parts, scene.stored()) == scene.ledger.exchange_gains(parts, scene.stored()));
      const ViewSlot slot(static_cast<std::uint32_t>(scene.random() % kSlots));
      for (CoverageLedger* ledger : {&copy, &scene.ledger}) {
        ledger->stored(slot) ? ledger->erase(slot) : ledger->insert(slot, parts);
      }
      CHECK(copy.summed_coverage() == scene.ledger.summed_coverage());
      for (ViewSlot other{0}; other < kSlots; ++other) CHECK(copy.loss(other) == scene.ledger.loss(other));
    }
    for (CellId cell{0}; cell < copy.cells(); ++cell) {
      CHECK(copy.references(cell) ==
            (options.metric == Metric::directions ? std::vector<ViewSlot>{} : scene.ledger.references(cell)));
    }
  }
}

TEST_CASE("the gain of an exchange is what scov rises by when it is made") {
  const CoverageOptions options = options_of(Metric::directions);
  Ledger scene(options);
  for (ViewSlot slot{0}; slot < kSlots; ++slot) scene.ledger.insert(slot, scene.offered());
  for (int round = 0; round < 60; ++round) {
    const std::vector<CellPart> parts = scene.offered();
    const std::vector<ViewSlot> slots = scene.stored();
    const std::vector<double> gains = scene.ledger.exchange_gains(parts, slots);
    const ViewSlot victim = slots[scene.random() % slots.size()];
    CHECK(gains[victim] == Approx(scene.ledger.joint_exchange_gain(parts, std::vector{victim})).margin(1e-6));
    const double before = scene.ledger.summed_coverage();
    scene.ledger.erase(victim);
    const double alone = scene.ledger.gain(parts);
    const double between = scene.ledger.summed_coverage();
    scene.ledger.insert(victim, parts);
    CHECK(scene.ledger.summed_coverage() - between == Approx(alone).margin(1e-6));
    CHECK(scene.ledger.summed_coverage() - before == Approx(gains[victim]).margin(1e-6));
  }
}

TEST_CASE("by the paper's metric, an exchange's gain is that of erasing and inserting where no reference is refilled") {
  for (const CoverageOptions& options : {options_of(Metric::paper), printed()}) {
    Ledger scene(options);
    // No more views than references: none waits for a place.
    for (ViewSlot slot{0}; slot < options.max_references; ++slot) {
      scene.ledger.insert(slot, random_half(scene.random, *scene.surface));
    }
    for (int round = 0; round < 40; ++round) {
      const std::vector<CellPart> parts = random_half(scene.random, *scene.surface);
      const std::vector<ViewSlot> slots = scene.stored();
      const std::vector<double> gains = scene.ledger.exchange_gains(parts, slots);
      for (const ViewSlot slot : slots) {
        CHECK(gains[slot] == Approx(scene.ledger.joint_exchange_gain(parts, std::vector{slot})).margin(1e-9));
      }
      const ViewSlot victim(static_cast<std::uint32_t>(scene.random() % slots.size()));
      scene.ledger.erase(victim);
      scene.ledger.insert(victim, parts);
    }
  }
}

TEST_CASE("fcov_max clamps what a cell counts for, not which views it refers to") {
  for (CoverageOptions options : {options_of(Metric::paper), printed()}) {
    options.max_cell_coverage = 0.5;
    const std::shared_ptr<const Surface> surface = room_surface();
    CoverageLedger ledger(*surface, kSlots, options, kMinReferenceGain);
    const glm::dvec3 normal = surface->cells.cells[0].normal;
    for (ViewSlot slot{0}; slot < options.max_references; ++slot) {
      ledger.insert(slot, {{0, {normal, 0.9}}});  // one of them is worth 0.585 or more
      CHECK(ledger.coverage(0) == 0.5);
    }
    CHECK(ledger.references(0).size() == options.max_references);
    // A full cell swaps by Delta_fcov for a better one.
    ledger.insert(ViewSlot(options.max_references), {{0, {normal, 1}}});
    const std::vector<ViewSlot> references = ledger.references(0);
    CHECK(std::count(references.begin(), references.end(), options.max_references) == 1);
    CHECK(ledger.coverage(0) == 0.5);
  }
}

TEST_CASE("references stay within their bound, refer to stored views that see the cell, and free places are taken") {
  for (const Metric metric : {Metric::directions, Metric::paper}) {
    const CoverageOptions options = options_of(metric);
    Ledger scene(options);
    for (int i = 0; i < 300; ++i) {
      step(scene);
      for (CellId cell{0}; cell < scene.surface->cells.cells.size(); ++cell) {
        std::set<std::uint32_t> seeing;
        for (const ViewSlot slot : scene.stored()) {
          for (const CellPart& entry : scene.ledger.parts(slot)) {
            if (entry.cell == cell && entry.part.positional > 0) seeing.insert(slot);
          }
        }
        const std::vector<ViewSlot> references = scene.ledger.references(cell);
        REQUIRE(std::all_of(references.begin(), references.end(), [&](auto slot) { return seeing.contains(slot); }));
        REQUIRE(std::set<std::uint32_t>(references.begin(), references.end()).size() == references.size());
        REQUIRE(references.size() <= options.max_references);
        if (metric == Metric::directions) {
          REQUIRE(references.size() == std::min<std::size_t>(seeing.size(), options.max_references));
        }
      }
    }
  }
}

TEST_CASE("by directions, a view more never makes the store worth less, and adds less the more there are") {
  const CoverageOptions options = options_of(Metric::directions);
  Ledger scene(options);
  for (int round = 0; round < 20; ++round) {
    // Two stores, one a part of the other.
    CoverageLedger small(*scene.surface, kSlots, options, 0);
    CoverageLedger large(*scene.surface, kSlots, options, 0);
    for (int i = 0; i < 5; ++i) {
      const std::vector<CellPart> asked = random_half(scene.random, *scene.surface);
      small.add_demand(asked);
      large.add_demand(asked);
    }
    for (std::uint32_t slot = 0; slot + 1 < kSlots; ++slot) {
      const std::vector<CellPart> parts = random_half(scene.random, *scene.surface);
      if (scene.random() % 2 == 0) small.insert(ViewSlot(slot), parts);
      large.insert(ViewSlot(slot), parts);
      const std::vector<CellPart> further = random_half(scene.random, *scene.surface);
      CHECK(large.gain(further) >= 0);
      CHECK(small.gain(further) >= large.gain(further) - 1e-6);
      CHECK(large.summed_coverage() >= small.summed_coverage() - 1e-6);
    }
  }
}

TEST_CASE("by directions, the order of arrival does not change what a store is worth") {
  const CoverageOptions options = options_of(Metric::directions);
  Ledger scene(options);
  std::vector<std::vector<CellPart>> views;
  for (ViewSlot slot{0}; slot < kSlots; ++slot) views.push_back(random_half(scene.random, *scene.surface));
  CoverageLedger forward(*scene.surface, kSlots, options, 0);
  CoverageLedger backward(*scene.surface, kSlots, options, 0);
  for (ViewSlot slot{0}; slot < kSlots; ++slot) {
    forward.add_demand(views[slot]);
    forward.insert(slot, views[slot]);
    backward.add_demand(views[kSlots - 1 - slot]);
    backward.insert(ViewSlot(kSlots - 1 - slot), views[kSlots - 1 - slot]);
  }
  CHECK(forward.summed_coverage() == Approx(backward.summed_coverage()).margin(1e-9));
  for (ViewSlot slot{0}; slot < kSlots; ++slot) {
    CHECK(forward.loss(slot) == Approx(backward.loss(slot)).margin(1e-6));
  }
}

TEST_CASE("a slot is filled once and emptied once") {
  Ledger scene(options_of(Metric::directions));
  scene.ledger.insert(3, random_half(scene.random, *scene.surface));
  CHECK_THROWS_AS(scene.ledger.insert(3, {}), std::logic_error);
  scene.ledger.erase(3);
  CHECK_THROWS_AS(scene.ledger.erase(3), std::logic_error);
  CHECK(scene.ledger.summed_coverage() == Approx(0).margin(1e-12));
}

}  // namespace
}  // namespace lumatlas
