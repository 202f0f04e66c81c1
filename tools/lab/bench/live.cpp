// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmark of what a live model does when a small part of its surface has changed, step by step. The surface is that
// of a capture's depth images. A table in Markdown goes to stdout; exit status as of lumatlas itself.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "blend/gl/egl_context.h"
#include "blend/renderer.h"
#include "planner/geometry_follower.h"
#include "planner/planner.h"
#include "planner/tile_choice.h"
#include "tools/lab/bench/program.h"
#include "tools/live/live_coverage.h"
#include "tools/live/live_surface.h"
#include "tools/live/playback/captured_stream.h"
#include "tools/meshing/depth/scene_depth.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kDrawnPixels = 320;  // longest side of the pictures

struct LiveBenchFlags {
  std::filesystem::path folder;
  std::vector<double> voxels{0.02, 0.014};
  std::uint32_t views = 100, every = 4, repeats = 3;
  double part = 0.01;
};

double ms_of(const std::chrono::steady_clock::time_point& start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// The middle of a depth image, a share of its pixels.
DepthImage middle_of(DepthImage image, double share) {
  const Camera& camera = image.camera;
  const double half = std::sqrt(share) / 2;
  for (std::uint32_t y = 0; y < camera.height; ++y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      const double u = (x + 0.5) / camera.width - 0.5, v = (y + 0.5) / camera.height - 0.5;
      if (std::max(std::abs(u), std::abs(v)) > half) image.depth[std::size_t{y} * camera.width + x] = 0;
    }
  }
  return image;
}

Camera shifted(Camera camera, double by) {
  camera.cam_from_world_translation.x += by;
  return camera;
}

struct Steps {
  GrowingTimes growing;
  double fusing = 0, taking = 0, counting = 0, snapshot = 0, loading = 0, layout = 0, drawing = 0;  // ms
  double changed = 0;  // share of the cells
};

class Bench {
 public:
  Bench(const CapturedStream& stream, const LiveBenchFlags& flags, double voxel)
      : stream_(stream), flags_(flags), surface_(options_of(stream, voxel)), voxel_(voxel) {
    std::size_t number = 0;
    for (const SceneDepth& depth : stream.scene.depths) {
      if (number++ % flags.every == 0) (void)surface_.add(read_flat_depth(depth));
    }
    moving_ = middle_of(read_flat_depth(stream.scene.depths.front()), share_of_image());
    (void)surface_.add(moving_, "moving");
    grown_ = surface_.grow(GrowingFusion::Show::everything).value();
    planner_options_.coverage.ideal_distance = surface_.usual_distance();
    atlas_ = std::make_unique<Atlas>(grown_.surface, flags.views, kWholeViews, choose_tiles);
    planner_ = std::make_unique<Planner>(*atlas_, *grown_.visibility, planner_options_);
    const std::size_t every = std::max<std::size_t>(1, stream.scene.views.size() / flags.views);
    for (std::size_t i = 0; i < stream.scene.views.size(); i += every) {
      const SceneView& view = stream.scene.views[i];
      (void)planner_->offer(view.name, view.camera, [&view] { return load_photograph(view); });
    }
    camera_ = stream.scene.views.front().camera.shrunk_to(kDrawnPixels);
    for (int picture = 0; picture < 2; ++picture) {  // cells of the first surface are joined
      renderer_.load(atlas_->snapshot());
      (void)renderer_.render(camera_, {});
    }
  }

  // Moves a part of the surface by half a voxel, and takes it over.
  Steps change(int round) {
    Steps steps;
    auto start = std::chrono::steady_clock::now();
    surface_.move("moving", shifted(moving_.camera, (round % 2 == 0 ? 0.5 : 0) * voxel_));
    while (surface_.follow_move()) {
    }
    steps.fusing = ms_of(start);
    GrownSurface next = surface_.grow().value();
    steps.growing = next.times;
    start = std::chrono::steady_clock::now();
    (void)GeometryFollower(*planner_).update_surface(next.surface, *next.visibility, next.previous_cell, next.changed,
                                                     DepthRenewal::later);
    steps.taking = ms_of(start);
    start = std::chrono::steady_clock::now();
    const LiveCoverage coverage(planner_->store(), 24, planner_options_);
    steps.counting = ms_of(start);
    start = std::chrono::steady_clock::now();
    const Snapshot snapshot = atlas_->snapshot();
    steps.snapshot = ms_of(start);
    start = std::chrono::steady_clock::now();
    renderer_.load(snapshot);
    steps.loading = ms_of(start);
    start = std::chrono::steady_clock::now();
    renderer_.make_ready({});
    steps.layout = ms_of(start);
    start = std::chrono::steady_clock::now();
    (void)renderer_.render(camera_, {});
    steps.drawing = ms_of(start);
    const auto changed = std::count(next.changed.begin(), next.changed.end(), 1);
    steps.changed = static_cast<double>(changed) / static_cast<double>(next.changed.size());
    std::swap(grown_, next);
    return steps;
  }

  [[nodiscard]] std::size_t faces() const { return grown_.surface->mesh.faces.size(); }
  [[nodiscard]] std::size_t held() const { return planner_->store().held_views(); }

 private:
  static LiveSurfaceOptions options_of(const CapturedStream& stream, double voxel) {
    LiveSurfaceOptions options;
    options.voxel = voxel;
    options.max_blocks = std::size_t{1} << 20U;
    options.offset = stream.offset;
    return options;
  }
  // An image shows some twentieth of a room.
  [[nodiscard]] double share_of_image() const { return std::min(1.0, 20 * flags_.part); }

  const CapturedStream& stream_;
  const LiveBenchFlags& flags_;
  LiveSurface surface_;
  double voxel_;
  DepthImage moving_;
  GrownSurface grown_;
  PlannerOptions planner_options_;
  std::unique_ptr<Atlas> atlas_;
  std::unique_ptr<Planner> planner_;
  EglContext context_;
  Renderer renderer_;
  Camera camera_;  // of the pictures
};

void run(const LiveBenchFlags& flags) {
  const CapturedStream stream = read_captured_stream(flags.folder, {}, std::nullopt, 10);
  std::cout
      << "| faces | cells changed | fusing again | cutting | repair | matching | cells | tree | store | coverage | "
         "snapshot | loading | layout | all until drawn | picture, ms "
         "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n"
      << std::fixed;
  for (const double voxel : flags.voxels) {
    Bench bench(stream, flags, voxel);
    // The first change lays out everything, because cells were joined, and the second because nothing can stay of that.
    for (int round = 0; round < 2; ++round) (void)bench.change(round);
    for (std::uint32_t round = 0; round < flags.repeats; ++round) {
      const Steps steps = bench.change(static_cast<int>(round));
      const GrowingTimes& t = steps.growing;
      const std::vector<double> ms{steps.fusing, t.cutting,      t.repairing,    t.matching,    t.cells,     t.tree,
                                   steps.taking, steps.counting, steps.snapshot, steps.loading, steps.layout};
      double all = 0;
      std::cout << "| " << bench.faces() << " | " << std::setprecision(1) << 100 * steps.changed << " %";
      for (const double step : ms) {
        all += step;
        std::cout << " | " << std::setprecision(0) << step;
      }
      std::cout << " | " << all << " | " << steps.drawing << " |" << std::endl;
    }
  }
}

}  // namespace

}  // namespace lumatlas

int main(int argc, char** argv) {
  using namespace lumatlas;
  CLI::App program("Measures what a live model does when a part of its surface changes", "bench_live");
  LiveBenchFlags flags;
  program.add_option("STREAM", flags.folder, "Capture with depth images, as `lumatlas synth lab --stream` writes it")
      ->required();
  program.add_option("--voxels", flags.voxels, "Sides of voxels, scene units")->capture_default_str();
  program.add_option("--views", flags.views, "Photographs in the store")->capture_default_str();
  program.add_option("--every", flags.every, "Fuse every N-th depth image")->capture_default_str();
  program.add_option("--part", flags.part, "Share of the surface that changes, about")->capture_default_str();
  program.add_option("--repeats", flags.repeats, "Changes at each voxel size")->capture_default_str();
  return run_program(program, "bench_live", argc, argv, [&] { run(flags); });
}
