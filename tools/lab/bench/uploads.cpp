// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmark of the steps that take a next snapshot to the GPU while the former one is drawn, for each kind of change of
// a store: calls, milliseconds of wall and of the drawing thread's processor time of all calls and of the longest, and
// the most bytes of one. The surface and its photographs are generated. A table in Markdown goes to stdout; exit status
// as of lumatlas itself.
#include <cmath>
#include <cstdint>
#include <functional>
#include <iomanip>
#include <iostream>
#include <memory>
#include <utility>
#include <vector>

#include "blend/gl/egl_context.h"
#include "blend/renderer.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/bench/sheet_store.h"
#include "tools/lab/timing/snapshot_time.h"

namespace lumatlas {

namespace {

struct Flags {
  std::uint32_t vertices = 500'000;
  std::uint32_t views = 100;
  std::uint32_t width = 160;
  double upload_ms = 4;
  bool aside = true;
};

constexpr std::size_t kReferences = 16;  // of a cell
constexpr double kHills = 0.01;

std::vector<Camera> cameras_over_sheet(std::uint32_t views) {
  std::vector<Camera> cameras;
  cameras.reserve(views);
  const auto columns = static_cast<std::uint32_t>(std::ceil(std::sqrt(views)));
  for (std::uint32_t view = 0; view < views; ++view) {
    const std::uint32_t row = view / columns;
    cameras.push_back(camera_above((view % columns + 0.5) / columns, (row + 0.5) / columns, 0.3, 640, 480));
  }
  return cameras;
}

// A store whose parts change, each in another way every time.
class ChangingStore {
 public:
  explicit ChangingStore(const Flags& flags) : flags_(flags) {
    const std::shared_ptr<const Surface> surface = hilly_sheet(flags.vertices, kHills);
    atlas_ = sheet_store(surface, *make_ray_visibility(surface->mesh), cameras_over_sheet(flags.views), kReferences);
  }

  [[nodiscard]] Snapshot snapshot() const { return atlas_->snapshot(); }

  void move_views() {
    std::vector<ViewPose> poses;
    for (ViewSlot view{0}; view < flags_.views; ++view) {
      Camera camera = atlas_->view(view)->camera;
      camera.cam_from_world_translation.x += 1e-4;
      poses.push_back({view, camera});
    }
    atlas_->set_poses(poses);
  }

  void change_depths() {
    constexpr float kFarther = 1.001F;
    for (ViewSlot view{0}; view < flags_.views; ++view) {
      auto mask = std::make_shared<ViewMask>(*atlas_->view(view)->mask);
      for (float& depth : mask->depth.values()) depth *= kFarther;
      atlas_->replace_mask(view, std::move(mask), *atlas_->shown(view));
    }
  }

  void move_surface() {
    hills_ *= 1.01;
    const std::shared_ptr<const Surface> surface = hilly_sheet(flags_.vertices, hills_);
    std::vector<CellId> same_cells;
    for (CellId cell{0}; cell < surface->cells.cells.size(); ++cell) same_cells.emplace_back(cell);
    atlas_->replace_surface(surface, same_cells);
  }

 private:
  Flags flags_;
  std::unique_ptr<Atlas> atlas_;
  double hills_ = kHills;
};

void print(const char* change, const std::vector<CallTimes>& all) {
  for (const CallTimes& times : all) {
    std::cout << "| " << change << " | " << times.what << " | " << times.calls << std::fixed << std::setprecision(2)
              << " | " << times.wall << " / " << times.processor << " | " << times.longest_wall << " / "
              << times.longest_processor << " | " << times.most_bytes << " |\n";
  }
  std::cout << std::flush;
}

void run(const Flags& flags) {
  const EglContext context;
  ChangingStore store(flags);
  RendererOptions options;
  if (!flags.aside) options.allocate_aside = false;
  Renderer renderer(options);
  const Camera camera = camera_above(0.5, 0.5, 0.4, flags.width, std::max(flags.width * 3 / 4, 1u));
  const Snapshot first = store.snapshot();
  renderer.load(first);
  (void)renderer.render(camera, {});
  std::cout << "Steps of a next snapshot of " << first.surface->mesh.faces.size() << " faces and " << flags.views
            << " photographs of 640x480, beside pictures " << flags.width << " pixels wide, with " << flags.upload_ms
            << " ms a frame, on " << context.description()
            << ". Milliseconds: wall / processor time of the thread that draws.\n\n"
               "| change | step | calls | all | longest | most bytes |\n|---|---|---|---|---|---|\n";
  const auto measure = [&](const char* change, const std::function<void()>& make_change) {
    make_change();
    print(change, time_steps(renderer, store.snapshot(), camera, {}, flags.upload_ms));
  };
  measure("poses", [&] { store.move_views(); });  // takes joined cells apart, too
  measure("poses again", [&] { store.move_views(); });
  measure("depths", [&] { store.change_depths(); });
  measure("surface", [&] { store.move_surface(); });
  measure("surface and depths", [&] {
    store.move_surface();
    store.change_depths();
  });
}

}  // namespace

}  // namespace lumatlas

int main(int argc, char** argv) {
  CLI::App program("Benchmark of what a next snapshot takes on the thread that draws, step by step", "bench_uploads");
  program.option_defaults()->always_capture_default();
  lumatlas::Flags flags;
  program.add_option("--vertices", flags.vertices, "About how many the surface has")->check(CLI::Range(4u, 100000000u));
  program.add_option("--views", flags.views, "Number of photographs, of 640 x 480 pixels each")
      ->check(CLI::Range(1u, 100000u));
  program.add_option("--width", flags.width, "Width of the pictures, pixels")->check(CLI::Range(1u, 16384u));
  program.add_option("--upload-ms", flags.upload_ms, "Milliseconds of each frame that upload() may take")
      ->check(CLI::Range(0.0, 1e6));
  program.add_flag("!--no-aside", flags.aside, "Allocate all memory on the thread that draws");
  return lumatlas::run_program(program, "bench_uploads", argc, argv, [&] { lumatlas::run(flags); });
}
