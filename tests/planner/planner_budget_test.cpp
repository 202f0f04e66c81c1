// SPDX-License-Identifier: GPL-3.0-or-later
// The planner's promises about its store: it stays within a budget of bytes, nothing changes if nothing is stored, and
// its value for any stream.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <stdexcept>

#include "planner/coverage/predicted_loss.h"
#include "planner/geometry_follower.h"
#include "planner/offline_planner.h"
#include "planner/planner.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

PlannerOptions without_refinement() {
  PlannerOptions options;
  options.coverage.ideal_distance = 2;
  options.coverage.max_references = 4;
  options.coverage.demand = false;  // else an offer changes what the store is worth, though nothing be stored
  options.visibility_px = 64;
  options.refinement.alignment.pose = options.refinement.alignment.exposure = false;
  return options;
}

PlannerOptions with_refinement() {
  PlannerOptions options = without_refinement();
  options.refinement = {};
  options.refinement.samples = 200;
  options.refinement.trust.grid_px = 48;
  return options;
}

// The room's camera with an image of `longer_side` pixels, at most 96.
Camera sized_camera(std::size_t number, std::uint32_t longer_side) {
  return room_camera(number).shrunk_to(longer_side);
}

struct Store {
  Store(std::uint32_t slots, const PlannerOptions& options)
      : surface(room_surface()),
        visibility(make_ray_visibility(surface->mesh)),
        atlas(surface, slots),
        planner(atlas, *visibility, options) {}

  Verdict offer(const std::string& name, const Camera& camera) {
    return planner.offer(name, camera, pattern_photograph(camera, 1));
  }
  // Bytes by name, of what is stored.
  [[nodiscard]] std::map<std::string, std::uint64_t> stored() const {
    std::map<std::string, std::uint64_t> bytes;
    for (const auto& view : atlas.snapshot().views) {
      if (view) bytes.emplace(view->name, stored_bytes(view->camera));
    }
    return bytes;
  }

  std::shared_ptr<const Surface> surface;
  std::unique_ptr<Visibility> visibility;
  Atlas atlas;
  Planner planner;
};

std::uint64_t sum_of(const std::map<std::string, std::uint64_t>& bytes) {
  return std::accumulate(bytes.begin(), bytes.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const auto& entry) { return sum + entry.second; });
}

// The parts of a store that affect another offer.
struct Image {
  std::map<std::string, std::uint64_t> stored;
  ReferenceTable references;
  std::vector<glm::dvec3> gains;
  std::uint64_t bytes;
  double coverage;

  explicit Image(const Store& store)
      : stored(store.stored()),
        references(store.atlas.snapshot().references),
        gains(store.atlas.snapshot().gains),
        bytes(store.planner.store().stored_bytes()),
        coverage(store.planner.store().summed_coverage()) {}
  [[nodiscard]] bool operator==(const Image& other) const {
    return stored == other.stored && references.offsets == other.references.offsets &&
           references.views == other.references.views && gains == other.gains && bytes == other.bytes &&
           coverage == Approx(other.coverage).epsilon(1e-12);  // with demand, sums in another order
  }
};

// The middle of the room's camera's picture, of a size divided by `divisor`: it sees less.
Camera cropped_camera(std::size_t number, std::uint32_t divisor) {
  Camera camera = room_camera(number);
  camera.width /= divisor;
  camera.height /= divisor;
  camera.cx /= divisor;
  camera.cy /= divisor;
  return camera;
}

// Offers views of mixed sizes and checks after each what became of the store. Returns the most views that left at once.
std::size_t offer_mixed_sizes(const PlannerOptions& options, int offers, std::uint32_t seed) {
  constexpr std::array<std::uint32_t, 4> kDivisors{1, 2, 3, 4};
  Store store(30, options);
  std::mt19937 random(seed);
  std::size_t most_victims = 0;
  std::map<std::string, std::uint64_t> before;
  for (int i = 0; i < offers; ++i) {
    const Camera camera = cropped_camera(random() % 500, kDivisors[random() % kDivisors.size()]);
    const std::string name = "view " + std::to_string(i);
    const double coverage = store.planner.store().summed_coverage();
    const Verdict verdict = store.offer(name, camera);
    const std::map<std::string, std::uint64_t> now = store.stored();
    REQUIRE(sum_of(now) <= options.max_bytes);
    REQUIRE(store.planner.store().stored_bytes() == sum_of(now));
    for (const std::string& left : verdict.replaced) REQUIRE(before.erase(left) == 1);
    if (verdict.slot) before.emplace(name, stored_bytes(camera));
    REQUIRE(now == before);
    const double rise = store.planner.store().summed_coverage() - coverage;
    REQUIRE(rise == Approx(verdict.slot ? verdict.gain : 0).margin(1e-6));
    REQUIRE(rise >= 0);
    REQUIRE((verdict.decision == Decision::replaced) == !verdict.replaced.empty());
    most_victims = std::max(most_victims, verdict.replaced.size());
  }
  return most_victims;
}

TEST_CASE("views of mixed sizes stay within a budget of bytes, and leave, even several, only for what is worth more") {
  PlannerOptions options = without_refinement();
  for (const double pictures : {1.0, 2.5, 4.2}) {
    options.max_bytes = static_cast<std::uint64_t>(pictures * static_cast<double>(stored_bytes(room_camera(0))));
    CHECK(offer_mixed_sizes(options, 300, 5) >= 2);
  }
}

TEST_CASE("the budget of bytes holds with refinement, which moves the views") {
  PlannerOptions options = with_refinement();
  options.refinement.least_correlation = -1;  // the photographs are not of the room: none is an outlier
  options.max_bytes = 5 * stored_bytes(room_camera(0)) / 2;
  CHECK(offer_mixed_sizes(options, 80, 6) >= 1);
}

TEST_CASE("small views of little worth leave for a large one though one large view alone would make room") {
  PlannerOptions options = without_refinement();
  options.min_view_gain = 0;
  const std::uint64_t large = stored_bytes(room_camera(0));
  options.max_bytes = 2 * large;
  Store store(30, options);
  store.offer("large", room_camera(0));
  // Four quarters of its size that see next to nothing: a corner each of a far wall.
  for (std::size_t i = 0; i < 4; ++i) {
    Camera narrow = sized_camera(40 + i, 48);
    narrow.fx *= 30;
    narrow.fy *= 30;
    REQUIRE(store.offer("narrow " + std::to_string(i), narrow).decision == Decision::kept);
  }
  Verdict verdict = store.offer("another large", room_camera(8));
  std::sort(verdict.replaced.begin(), verdict.replaced.end());
  CHECK(verdict.replaced == std::vector<std::string>{"narrow 0", "narrow 1", "narrow 2", "narrow 3"});
  CHECK(store.planner.store().stored_bytes() == 2 * large);
}

TEST_CASE("a view larger than the budget is refused by name and changes nothing") {
  PlannerOptions options = without_refinement();
  options.max_bytes = 2 * stored_bytes(sized_camera(0, 48));
  Store store(5, options);
  for (std::size_t i = 0; i < 3; ++i) store.offer("small " + std::to_string(i), sized_camera(i, 48));
  const Image before(store);
  int asked = 0;
  const PhotographSource source = [&] {
    ++asked;
    return pattern_photograph(room_camera(9), 9);
  };
  CHECK_THROWS_WITH(store.planner.offer("huge", room_camera(9), source),
                    "planner: view huge takes 69120 bytes, more than all views together may (34560)");
  CHECK_THROWS_WITH(store.planner.force_store("huge", room_camera(9), source),
                    Catch::Contains("no room to keep view huge"));
  CHECK(asked == 0);
  CHECK(Image(store) == before);
}

TEST_CASE("a photograph is asked for once if the view is stored, and never if it is rejected") {
  Store store(4, without_refinement());
  std::size_t rejected = 0;
  for (std::size_t i = 0; i < 80; ++i) {
    const Camera camera = room_camera((13 * i) % 50);
    std::size_t asked = 0;
    const Verdict verdict = store.planner.offer(std::to_string(i), camera, [&] {
      ++asked;
      return pattern_photograph(camera, i);
    });
    REQUIRE(asked == (verdict.decision == Decision::rejected ? 0 : 1));
    rejected += verdict.decision == Decision::rejected;
  }
  CHECK(rejected > 10);
  CHECK(rejected < 70);
}

TEST_CASE("views that are reserved first and filled later make the store of the stream, from fewer photographs") {
  constexpr std::array<std::uint32_t, 3> kDivisors{1, 2, 3};
  for (const double pictures : {0.0, 4.2}) {
    PlannerOptions options = without_refinement();
    options.max_bytes = static_cast<std::uint64_t>(pictures * static_cast<double>(stored_bytes(room_camera(0))));
    Store stream(6, options), ahead(6, options);
    std::vector<Verdict> verdicts;
    for (std::size_t i = 0; i < 60; ++i) {
      const Camera camera = cropped_camera((13 * i) % 50, kDivisors[i % kDivisors.size()]);
      const std::string name = std::to_string(i);
      const Verdict offered = stream.offer(name, camera);
      verdicts.push_back(ahead.planner.reserve(name, camera));
      REQUIRE(verdicts.back().decision == offered.decision);
      REQUIRE(verdicts.back().slot == offered.slot);
      REQUIRE(verdicts.back().replaced == offered.replaced);
      REQUIRE(verdicts.back().gain == offered.gain);
      REQUIRE(ahead.planner.store().stored_bytes() == stream.planner.store().stored_bytes());
    }
    CHECK(ahead.planner.store().stored_views() == 0);
    std::size_t filled = 0;
    for (std::size_t i = 0; i < verdicts.size(); ++i) {
      const std::string name = std::to_string(i);
      if (!verdicts[i].slot || ahead.planner.store().promised_camera(name, *verdicts[i].slot) == nullptr) continue;
      const Camera camera = cropped_camera((13 * i) % 50, kDivisors[i % kDivisors.size()]);
      ahead.planner.store_reserved(
          name, [&] { return pattern_photograph(camera, 1); }, verdicts[i]);
      CHECK(ahead.planner.store().promised_camera(name, *verdicts[i].slot) == nullptr);
      ++filled;
    }
    CHECK(filled == stream.planner.store().stored_views());
    CHECK(Image(ahead) == Image(stream));
  }
}

TEST_CASE("a promised slot waits for its photograph, and only such a slot is filled") {
  Store store(3, without_refinement());
  Verdict verdict = store.planner.reserve("later", room_camera(0));
  REQUIRE(verdict.slot == 0u);
  CHECK(store.planner.store().promised_camera("later", 0) != nullptr);
  CHECK(store.planner.store().promised_camera("another", 0) == nullptr);
  CHECK(store.planner.store().promised_camera("later", 1) == nullptr);
  CHECK(store.planner.store().promised_camera("later", 3) == nullptr);
  CHECK(store.planner.store().summed_coverage() > 0);
  CHECK(store.atlas.size() == 0);
  const PhotographSource broken = []() -> Photograph { throw std::runtime_error("the file is gone"); };
  CHECK_THROWS_WITH(store.planner.store_reserved("later", broken, verdict), "the file is gone");
  CHECK_THROWS_AS(store.planner.store_reserved(
                      "later", [] { return Photograph{}; }, verdict),
                  std::invalid_argument);
  CHECK_THROWS_WITH(store.planner.store_reserved("later", {}, verdict),
                    Catch::Contains("no function for its photograph"));
  CHECK(store.planner.store().promised_camera("later", 0) != nullptr);
  CHECK_THROWS_AS(GeometryFollower(store.planner).update_surface(store.surface, *store.visibility, {}, {}),
                  std::logic_error);
  // A view that comes in between takes the next slot, and refers to nothing that is not there.
  REQUIRE(store.offer("now", room_camera(8)).slot == 1u);
  CHECK_THROWS_WITH(store.planner.store_reserved("another", broken, verdict),
                    "planner: view another is promised no slot");
  store.planner.store_reserved(
      "later", [] { return pattern_photograph(room_camera(0), 1); }, verdict);
  CHECK(store.stored().size() == 2);
  CHECK_THROWS_AS(store.planner.store_reserved("later", broken, verdict), std::logic_error);
  Verdict rejected;
  CHECK_THROWS_AS(store.planner.store_reserved("later", broken, rejected), std::logic_error);

  PlannerOptions bounded = without_refinement();
  bounded.coverage = parsimony_coverage(bounded.coverage);
  bounded.max_loss_db = 0.1;
  Store thinned(3, bounded);
  CHECK_THROWS_AS(thinned.planner.reserve("later", room_camera(0)), std::logic_error);
  CHECK_THROWS_AS(thinned.planner.offer_again("later", room_camera(0), broken), std::logic_error);
}

TEST_CASE("a photograph that cannot be had, or is not of its camera's size, leaves the store as it was") {
  for (PlannerOptions options : {without_refinement(), with_refinement()}) {
    options.min_view_gain = 0;
    options.coverage.demand = true;
    options.coverage.demand_prior = 0;  // so that what was seen once counts
    Store store(2, options);
    const std::array<std::size_t, 2> alike{5, 5};  // so that another gains
    for (const std::size_t number : alike)
      store.planner.force_store("kept", room_camera(number),
                                [&] { return pattern_photograph(room_camera(number), number); });
    const Image before(store);
    const PhotographSource broken = []() -> Photograph { throw std::runtime_error("the file is gone"); };
    CHECK_THROWS_WITH(store.planner.offer("broken", room_camera(20), broken), "the file is gone");
    CHECK(Image(store) == before);
    CHECK_THROWS_WITH(store.planner.offer("empty", room_camera(20), Photograph{}),
                      Catch::Contains("view empty") && Catch::Contains("0x0"));
    CHECK_THROWS_WITH(store.planner.offer("small", room_camera(20), pattern_photograph(sized_camera(20, 48), 1)),
                      Catch::Contains("48x36") && Catch::Contains("96x72"));
    CHECK(Image(store) == before);
    CHECK(store.offer("whole", room_camera(20)).decision != Decision::rejected);
  }
}

TEST_CASE("a view that is stored already takes no place, its own or another's, in a full store that keeps all gains") {
  PlannerOptions options = without_refinement();
  options.min_view_gain = 0;
  options.coverage.views_per_direction = 1;
  Store store(6, options);
  for (std::size_t i = 0; i < 200; ++i) store.offer(std::to_string(i), room_camera((13 * i) % 100));
  const Image before(store);
  for (const auto& view : store.atlas.snapshot().views) {
    CHECK(store.offer("again", view->camera).decision == Decision::rejected);
  }
  CHECK(Image(store) == before);
}

TEST_CASE("to consider only the lowest-ranked victims never gains more than to consider all") {
  std::size_t less = 0;
  for (std::size_t round = 0; round < 25; ++round) {
    std::vector<double> gains;
    for (const std::uint32_t victims : {1u, 3u, 0u}) {
      PlannerOptions options = without_refinement();
      options.victims = victims;
      Store store(6, options);
      for (std::size_t i = 0; i < 6; ++i) {
        const Camera camera = room_camera(7 * i + 11 * round);
        store.planner.force_store(std::to_string(i), camera, [&] { return pattern_photograph(camera, i); });
      }
      gains.push_back(store.offer("candidate", room_camera(3 + 5 * round)).gain);
    }
    CHECK(gains[0] <= gains[1]);
    CHECK(gains[1] <= gains[2]);
    less += gains[0] < gains[2];
  }
  CHECK(less > 0);  // else nothing was compared
}

// Cameras that see from a few cells to much of the room, so that orders by worth differ by orders of magnitude.
std::vector<Camera> cameras_of_all_worths(std::size_t count) {
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < count; ++i) {
    Camera camera = sized_camera(i, 64);
    const double zoom = std::exp2(static_cast<double>(i % 12) / 2);
    camera.fx *= zoom;
    camera.fy *= zoom;
    cameras.push_back(camera);
  }
  return cameras;
}

TEST_CASE("with the rule that has a proven bound, no order of the stream leaves less than a quarter of the best") {
  PlannerOptions options = without_refinement();
  options.min_view_gain = 0;
  options.min_exchange_gain = 1;
  const std::vector<Camera> cameras = cameras_of_all_worths(72);
  std::vector<std::vector<CellPart>> parts;
  std::vector<double> worth;
  const Store measure(1, options);
  for (const Camera& camera : cameras) {
    parts.push_back(measure.planner.parts_of(camera));
    worth.push_back(CoverageLedger(*measure.surface, 1, options.coverage, 0).gain(parts.back()));
  }
  std::vector<std::size_t> order(cameras.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937 random(8);
  for (const std::uint32_t slots : {1u, 2u, 5u, 12u}) {
    for (int round = 0; round < 4; ++round) {
      // By chance; rising in small steps, each too little to be taken; falling; the worst first, then by chance.
      std::shuffle(order.begin(), order.end(), random);
      const auto less = [&](std::size_t a, std::size_t b) { return worth[a] < worth[b]; };
      if (round == 1) std::sort(order.begin(), order.end(), less);
      if (round == 2) std::sort(order.rbegin(), order.rend(), less);
      if (round == 3) std::partial_sort(order.begin(), order.begin() + slots, order.end(), less);
      Store store(slots, options);
      std::vector<std::vector<CellPart>> offered;
      for (const std::size_t i : order) {
        store.offer(std::to_string(i), cameras[i]);
        offered.push_back(parts[i]);
        if (offered.size() % 12 != 0) continue;
        const OfflineChoice best = plan_offline(*store.surface, offered, slots, {options.coverage, 0});
        CHECK(store.planner.store().summed_coverage() >= best.summed_coverage / 4);
        CHECK(store.planner.store().summed_coverage() <= best.summed_coverage * std::exp(1) / (std::exp(1) - 1));
      }
    }
  }
}

}  // namespace
}  // namespace lumatlas
