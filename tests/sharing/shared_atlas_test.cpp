// SPDX-License-Identifier: GPL-3.0-or-later
// One atlas, shared as in a live viewer: the planner goes on offering views to it on a thread of its own, while others
// take snapshots and draw them. The preset tsan runs this under ThreadSanitizer.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "blend/reference.h"
#include "blend/renderer.h"
#include "planner/planner.h"
#include "planner/tile_choice.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

constexpr std::uint32_t kCapacity = 6;
constexpr std::size_t kOffered = 24;
constexpr TileOptions kTiles{.tile_px = 16, .gutter_px = 2, .max_tiles = 60};  // fewer than the references would need

PlannerOptions options_for_room() {
  PlannerOptions options;
  options.coverage.ideal_distance = 2;
  options.coverage.max_references = 4;
  options.visibility_px = 64;
  options.refinement.samples = 500;
  return options;
}

// A planner that fills, replaces and refines the views of its atlas on a thread of its own.
class PlannerThread {
 public:
  explicit PlannerThread(const TileOptions& layout)
      : surface_(room_surface()),
        visibility_(make_ray_visibility(surface_->mesh)),
        atlas_(surface_, kCapacity, layout, choose_tiles) {
    thread_ = std::thread([this] { plan(); });
  }
  ~PlannerThread() { wait(); }
  PlannerThread(const PlannerThread&) = delete;
  PlannerThread& operator=(const PlannerThread&) = delete;

  void wait() {
    if (thread_.joinable()) thread_.join();
  }
  [[nodiscard]] bool done() const { return done_; }
  [[nodiscard]] const Atlas& atlas() const { return atlas_; }

 private:
  void plan() {
    Planner planner(atlas_, *visibility_, options_for_room());
    for (std::size_t number = 0; number < kOffered; ++number) {
      const Camera camera = room_camera(7 * number % kOffered);
      (void)planner.offer("view " + std::to_string(number), camera, pattern_photograph(camera, number));
    }
    (void)planner.refiner().polish();
    planner.refiner().publish_refined();
    done_ = true;
  }

  std::shared_ptr<const Surface> surface_;
  std::unique_ptr<Visibility> visibility_;
  Atlas atlas_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

// Every reference is to a view that the snapshot holds, and every table is as long as the surface says.
bool is_consistent(const Snapshot& snapshot) {
  const std::size_t cells = snapshot.surface->cells.cells.size();
  return snapshot.references.offsets.size() == cells + 1 && snapshot.cell_seen.size() == cells &&
         snapshot.vertex_colors.size() == snapshot.surface->mesh.positions.size() &&
         snapshot.gains.size() == snapshot.views.size() &&
         std::all_of(snapshot.references.views.begin(), snapshot.references.views.end(),
                     [&](ViewSlot slot) { return snapshot.views[slot] != nullptr; });
}

// From a place that no view is offered from.
Rendering drawn_by_reference(const Snapshot& snapshot, const Visibility& visibility) {
  const Camera camera = room_camera(kOffered + 5);
  return render_reference(snapshot, camera, visibility.trace(camera), {});
}

TEST_CASE("what a snapshot shows is whole and stays the same while the planner goes on") {
  const TileOptions layout = GENERATE(kWholeViews, kTiles);
  CAPTURE(layout.tile_px);
  PlannerThread planner(layout);
  const auto visibility = make_ray_visibility(planner.atlas().surface()->mesh);
  struct Taken {
    Snapshot snapshot;
    Rendering picture;
  };
  std::vector<Taken> taken;
  bool last = false;
  while (!last) {
    last = planner.done();
    Snapshot snapshot = planner.atlas().snapshot();
    REQUIRE(is_consistent(snapshot));
    Rendering picture = drawn_by_reference(snapshot, *visibility);
    taken.push_back({std::move(snapshot), std::move(picture)});
  }
  planner.wait();
  for (const Taken& moment : {taken.front(), taken[taken.size() / 2], taken.back()}) {
    const Rendering again = drawn_by_reference(moment.snapshot, *visibility);
    CHECK(again.picture.rgb == moment.picture.picture.rgb);
    CHECK(again.state == moment.picture.state);
  }
  const auto& state = taken.back().picture.state;
  CHECK(std::count(state.begin(), state.end(), PixelState::textured) > 1000);  // of 96 x 72
}

TEST_CASE("two threads may take snapshots at once, and each goes forward in time") {
  PlannerThread planner(kTiles);
  std::atomic<std::size_t> inconsistent{0};
  std::atomic<std::size_t> backward{0};
  const auto watch = [&] {
    std::size_t seen = 0;
    bool last = false;
    while (!last) {
      last = planner.done();
      const Snapshot snapshot = planner.atlas().snapshot();
      inconsistent += is_consistent(snapshot) ? 0 : 1;
      const auto now = static_cast<std::size_t>(std::count(snapshot.cell_seen.begin(), snapshot.cell_seen.end(), 1));
      backward += now < seen ? 1 : 0;  // a cell that was seen stays so
      seen = now;
    }
  };
  std::thread other(watch);
  watch();
  other.join();
  CHECK(inconsistent == 0);
  CHECK(backward == 0);
}

TEST_CASE("a snapshot never shows that a view has left without the one that takes its place") {
  PlannerThread planner(kWholeViews);
  std::ptrdiff_t most = 0;
  bool last = false;
  while (!last) {
    last = planner.done();
    const Snapshot snapshot = planner.atlas().snapshot();
    const auto views =
        std::count_if(snapshot.views.begin(), snapshot.views.end(), [](const auto& view) { return view; });
    CHECK(views >= most);
    most = std::max(most, views);
  }
  CHECK(most == kCapacity);
}

TEST_CASE("the GPU draws what the reference draws of snapshots taken while the planner goes on") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  PlannerThread planner(kTiles);
  const auto visibility = make_ray_visibility(planner.atlas().surface()->mesh);
  Renderer renderer;
  std::size_t pixels = 0;
  std::size_t different = 0;
  bool last = false;
  while (!last) {
    last = planner.done();
    const Snapshot snapshot = planner.atlas().snapshot();
    renderer.load(snapshot);
    const Rendering gpu = renderer.render(room_camera(kOffered + 5), {});
    const Rendering cpu = drawn_by_reference(snapshot, *visibility);
    pixels += cpu.state.size();
    for (std::size_t pixel = 0; pixel < cpu.state.size(); ++pixel) different += cpu.state[pixel] != gpu.state[pixel];
  }
  INFO(different << " of " << pixels << " pixels are of another state");
  CHECK(static_cast<double>(different) <=
        0.001 * static_cast<double>(pixels));  // silhouettes, as in random_scenes_test
}

TEST_CASE("another thread prepares the snapshots that the GPU draws, and the former one is drawn meanwhile") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  PlannerThread planner(kTiles);
  Renderer renderer({.join_cells = false, .waiting_bytes = 1});
  const Camera camera = room_camera(kOffered + 5);
  std::optional<Rendering> former;
  std::size_t different = 0;
  bool last = false;
  while (!last) {
    last = planner.done();
    const Snapshot snapshot = planner.atlas().snapshot();
    NextSnapshot next = renderer.begin(snapshot, {});
    std::thread worker([&next] { next.prepare(); });
    int pieces = 0;
    while (!renderer.upload(0)) {
      if (!former || ++pieces % 50 > 0) continue;
      different += renderer.render(camera, {}).picture.rgb != former->picture.rgb;
    }
    worker.join();
    Renderer fresh({.join_cells = false});
    fresh.load(snapshot);
    former = renderer.render(camera, {});
    different += fresh.render(camera, {}).picture.rgb != former->picture.rgb;
  }
  CHECK(different == 0);
}

}  // namespace
}  // namespace lumatlas
