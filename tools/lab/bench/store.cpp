// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmark of a store that changes: milliseconds of a snapshot after one view has moved, of new poses of all views
// until a snapshot has them, of what a renderer uploads for a new pose and for a new mask; and memory of a model
// that is read with few resident tiles. The surface and its photographs are generated. JSON goes to stdout; exit
// status as of lumatlas itself.
#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/model/model_file.h"
#include "blend/gl/egl_context.h"
#include "blend/renderer.h"
#include "mesh/base/median.h"
#include "tools/base/elapsed.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/bench/sheet_store.h"

namespace lumatlas {

namespace {

struct Flags {
  std::uint32_t vertices = 1'200'000;
  std::uint32_t views = 300;
  std::uint32_t repeats = 9;
  bool upload = true;
  std::string model;  // a folder for a model that is written and read; empty: that is not measured
};

// Returns the median of the times that `work` takes after `prepare`, milliseconds.
double median_ms(std::uint32_t repeats, const std::function<void()>& prepare, const std::function<void()>& work) {
  std::vector<double> times;
  for (std::uint32_t i = 0; i < repeats; ++i) {
    prepare();
    const auto start = std::chrono::steady_clock::now();
    work();
    times.push_back(ms_since(start));
  }
  return percentile(times, 0.5);
}

Camera moved(const Atlas& atlas, ViewSlot slot) {
  Camera camera = atlas.view(slot)->camera;
  camera.cam_from_world_translation.x += 1e-4;
  return camera;
}

void move(Atlas& atlas, ViewSlot slot) {
  const ViewPose pose{slot, moved(atlas, slot)};
  atlas.set_poses({&pose, 1});
}

nlohmann::json measured_store(const std::shared_ptr<const Surface>& surface, const Visibility& visibility,
                              const Flags& flags) {
  // They leave a tenth of the sheet to no view.
  std::vector<Camera> cameras;
  const auto columns = static_cast<std::uint32_t>(std::ceil(std::sqrt(flags.views * 4.0 / 3)));
  cameras.reserve(flags.views);
  for (std::uint32_t view = 0; view < flags.views; ++view) {
    const std::uint32_t row = view / columns;
    cameras.push_back(
        camera_above(0.9 * (view % columns + 0.5) / columns, 1.2 * static_cast<double>(row) / columns, 0.12, 160, 120));
  }
  const std::unique_ptr<Atlas> atlas = sheet_store(surface, visibility, cameras);
  nlohmann::json result;
  Snapshot snapshot;
  result["first_snapshot_ms"] = median_ms(
      1, [] {}, [&] { snapshot = atlas->snapshot(); });
  const auto take = [&] { snapshot = atlas->snapshot(); };
  std::uint32_t slot = 0;
  const auto move_next = [&] { move(*atlas, ViewSlot(slot++ % flags.views)); };
  result["first_colors_ms"] = median_ms(
      1, [] {}, [&] { (void)snapshot.vertex_colors.get(); });
  result["snapshot_after_a_moved_view_ms"] = median_ms(flags.repeats, move_next, take);
  result["colors_after_a_moved_view_ms"] = median_ms(
      flags.repeats,
      [&] {
        move_next();
        take();
      },
      [&] { (void)snapshot.vertex_colors.get(); });
  result["snapshot_after_no_change_ms"] = median_ms(
      flags.repeats, [] {}, take);
  result["new_poses_of_all_until_in_a_snapshot_ms"] = median_ms(
      flags.repeats, [] {},
      [&] {
        std::vector<ViewPose> poses;
        for (ViewSlot view{0}; view < flags.views; ++view) poses.push_back({view, moved(*atlas, view)});
        atlas->set_poses(poses);
        take();
      });
  return result;
}

nlohmann::json measured_uploads(const std::shared_ptr<const Surface>& surface, const Visibility& visibility,
                                const Flags& flags) {
  const EglContext context;
  std::vector<Camera> cameras;
  cameras.reserve(4);
  for (const double x : {0.3, 0.4, 0.5, 0.6}) cameras.push_back(camera_above(x, 0.5, 0.5, 1920, 1080));
  const std::unique_ptr<Atlas> atlas = sheet_store(surface, visibility, cameras);
  Renderer renderer;
  Snapshot snapshot;
  const auto draw = [&] {
    renderer.draw(cameras[1], {});
    glFinish();
  };
  const auto load = [&] { renderer.load(snapshot); };
  const auto load_and_finish = [&] {
    load();
    glFinish();
  };
  const auto after = [&](const std::function<void()>& change, const std::function<void()>& work) {
    return median_ms(
        flags.repeats,
        [&] {
          draw();
          change();
          snapshot = atlas->snapshot();
        },
        work);
  };
  snapshot = atlas->snapshot();
  load();
  nlohmann::json result{{"context", context.description()}};
  const auto move_one = [&] { move(*atlas, 1); };
  result["load_after_a_new_pose_ms"] = after(move_one, load);
  result["load_after_a_new_pose_until_the_driver_is_done_ms"] = after(move_one, load_and_finish);
  int step = 0;
  const auto mask_one = [&] {
    auto mask = std::make_shared<ViewMask>(*atlas->view(1)->mask);
    std::vector<std::uint8_t>& validity = mask->validity.values();
    for (std::size_t pixel = 0; pixel < validity.size(); pixel += 3) {
      validity[pixel] = static_cast<std::uint8_t>(100 + step);
    }
    ++step;
    atlas->replace_mask(1, std::move(mask), *atlas->shown(1));
  };
  result["load_after_a_new_mask_until_the_driver_is_done_ms"] = after(mask_one, load_and_finish);
  result["draw_ms"] = median_ms(
      flags.repeats, [] {}, draw);
  return result;
}

// Reads a model of photographs of 12 megapixels, each with one resident tile.
nlohmann::json measured_reading(const Flags& flags) {
  constexpr std::uint32_t kViews = 8, kWidth = 4000, kHeight = 3000, kTile = 1510;
  const std::shared_ptr<const Surface> surface = hilly_sheet(10'000);
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(surface->mesh);
  Atlas atlas(surface, kViews, kSheetLayout);
  std::vector<ViewSlot> slots(kViews);
  for (std::uint32_t view = 0; view < kViews; ++view) {
    const Camera camera = camera_above(0.5, 0.5, 0.5 + 0.01 * view, kWidth, kHeight);
    slots[view] = atlas.insert(make_stored_view("view " + std::to_string(view), camera, noise(kWidth, kHeight, view),
                                                visibility->trace_sparsely(camera), {}),
                               {{kTile, CellId(0), 1}});
  }
  atlas.set_references(0, slots);
  std::filesystem::create_directories(flags.model);
  write_model(flags.model, atlas.snapshot(), {});
  Model model;
  const double ms = median_ms(
      flags.repeats, [&] { model = {}; }, [&] { model = read_model(flags.model); });
  std::size_t held = 0;
  for (const auto& view : model.snapshot.views) held += view->photograph->bytes() + view->mask->bytes();
  return {{"views", kViews},
          {"resident_tiles", model.snapshot.tiles.resident_tiles()},
          {"milliseconds", ms},
          {"bytes_of_views", held},
          {"bytes_of_whole_views", std::size_t{kViews} * kWidth * kHeight * (3 + sizeof(float) + 2)}};
}

void run(const Flags& flags) {
  const std::shared_ptr<const Surface> surface = hilly_sheet(flags.vertices);
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(surface->mesh);
  nlohmann::json result{{"vertices", surface->mesh.positions.size()},
                        {"faces", surface->mesh.faces.size()},
                        {"cells", surface->cells.cells.size()},
                        {"views", flags.views}};
  result["store"] = measured_store(surface, *visibility, flags);
  if (!flags.model.empty()) result["read_12_megapixels"] = measured_reading(flags);
  if (flags.upload) result["upload_1080p"] = measured_uploads(surface, *visibility, flags);
  std::cout << result.dump(2) << '\n';
}

}  // namespace

}  // namespace lumatlas

int main(int argc, char** argv) {
  CLI::App program("Benchmark of lumatlas's store: what a change costs until it is in a snapshot and on the GPU");
  program.option_defaults()->always_capture_default();
  lumatlas::Flags flags;
  program.add_option("--vertices", flags.vertices, "About how many the surface has")->check(CLI::Range(4u, 100000000u));
  program.add_option("--views", flags.views, "Of 160 x 120 pixels")->check(CLI::Range(1u, 100000u));
  program.add_option("--repeats", flags.repeats, "Times that each is measured; medians are printed")
      ->check(CLI::Range(1u, 10000u));
  program.add_flag("!--no-upload", flags.upload, "Do not measure uploads, which need OpenGL");
  program.add_option("--model", flags.model, "A folder for a model that is written and read; none: not measured");
  return lumatlas::run_program(program, "bench_store", argc, argv, [&] { lumatlas::run(flags); });
}
