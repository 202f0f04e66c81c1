// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/fewer_faces.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "blend/gpu_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/pipeline/bounded_build.h"
#include "tests/tools/pipeline/sharp_scene.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/output/build_summary.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {
namespace {

// An apartment of 16 views of 96 x 72 on a mesh far finer than they show.
const std::filesystem::path& fine_scene() {
  static const TemporaryFolder folder;
  static const bool made = (write_apartment(folder.path(), 16, 20000), true);
  REQUIRE(made);
  return folder.path();
}

CellOptions large_cells() {
  CellOptions cells;
  cells.size = 3;
  return cells;
}

// All views are stored, and then faces are given up within the bound.
BuildOptions with_face_loss(double max_face_loss_db) {
  BuildOptions options = bounded_build(max_face_loss_db);
  options.faces.pixels = 0.5;
  options.cells = large_cells();
  options.bound = Bound::of_loss(max_face_loss_db, max_face_loss_db);
  return options;
}

std::size_t faces_of(const BuildResult& result) {
  return result.snapshot.surface->mesh.faces.size();
}

TEST_CASE("a surface leaves most of a budget to photographs, and is as it was where it does so already") {
  const SurfaceInput whole = load_surface(fine_scene(), {}, large_cells());
  const std::uint64_t bytes = GpuByteCount(whole.surface).of_surface();
  CHECK(with_room_for_photographs(whole, large_cells(), 100 * bytes, 1000 * bytes).surface == whole.surface);
  CHECK(with_room_for_photographs(whole, large_cells(), 4 * bytes, 3 * bytes).surface == whole.surface);
  const SurfaceInput slightly = with_room_for_photographs(whole, large_cells(), 4 * bytes, 3 * bytes + bytes / 4);
  CHECK(slightly.surface->mesh.faces.size() < whole.surface->mesh.faces.size());
  CHECK(GpuByteCount(slightly.surface).of_surface() > bytes / 2);
  std::size_t last = whole.surface->mesh.faces.size();
  for (const std::uint64_t budget : {4 * bytes, 2 * bytes}) {
    const SurfaceInput fewer = with_room_for_photographs(whole, large_cells(), budget, budget);
    const std::uint64_t taken = GpuByteCount(fewer.surface).of_surface();
    CAPTURE(budget, taken);
    CHECK(taken <= budget / 7);
    CHECK(taken > budget / 16);
    const std::size_t faces = fewer.surface->mesh.faces.size();
    CHECK(faces < last);
    CHECK(fewer.simplified_faces == whole.surface->mesh.faces.size() - whole.split_faces - (faces - fewer.split_faces));
    CHECK(fewer.simplified_distance >= 0);
    CHECK(fewer.surface->cells.size == whole.surface->cells.size);
    CHECK(fewer.surface->offset == whole.surface->offset);
    last = faces;
  }
  // Faces that were split for their cells do not count as faces of the file.
  CellOptions small_cells;
  small_cells.size = 0.2;
  const SurfaceInput split = load_surface(fine_scene(), {}, small_cells);
  REQUIRE(split.split_faces > 0);
  const SurfaceInput of_split = with_fewer_faces(split, small_cells, {.faces = 5000});
  CHECK(of_split.simplified_faces + of_split.surface->mesh.faces.size() - of_split.split_faces ==
        whole.surface->mesh.faces.size() - whole.split_faces);
  const SurfaceInput least = with_room_for_photographs(whole, large_cells(), 1000, 1000);
  CHECK(least.surface->mesh.faces.size() > 3 * whole.surface->cells.cells.size());
  CHECK(least.surface->mesh.faces.size() < last);
}

TEST_CASE("cells grow where their faces would leave too little to photographs, unless they were given a size") {
  const SurfaceInput whole = load_surface(fine_scene(), {}, {});
  const double size = whole.surface->cells.size;
  const std::uint64_t bytes = GpuByteCount(whole.surface).of_surface();
  const SurfaceInput room = with_room_for_photographs(whole, {}, 2 * bytes, 2 * bytes);
  const std::uint64_t taken = GpuByteCount(room.surface).of_surface();
  CHECK(taken <= bytes / 4 * 11 / 10);
  CHECK(taken > bytes / 8);
  CHECK(room.surface->cells.size > 1.2 * size);
  CHECK(room.surface->cells.cells.size() < whole.surface->cells.cells.size() / 2);
  CellOptions given;
  given.size = size;
  const SurfaceInput kept = with_room_for_photographs(whole, given, 2 * bytes, 2 * bytes);
  CHECK(kept.surface->cells.size == size);
  CHECK(GpuByteCount(kept.surface).of_surface() > taken);
  const SurfaceInput largest = with_room_for_photographs(whole, {}, 1000, 1000);
  CHECK(largest.surface->cells.size == Approx(4 * size));
}

TEST_CASE("cells grow little where a mesh of fewer faces than cells need gives up little") {
  CellOptions small;
  small.size = 0.2;
  const SurfaceInput fine = load_surface(fine_scene(), {}, small);
  REQUIRE(4 * fine.surface->cells.cells.size() > fine.surface->mesh.faces.size() - fine.split_faces);
  const std::uint64_t bytes = GpuByteCount(fine.surface).of_surface();
  const SurfaceInput fewer = with_room_for_photographs(fine, {}, 2 * bytes, bytes + bytes / 10);
  const std::uint64_t taken = GpuByteCount(fewer.surface).of_surface();
  CHECK(taken <= bytes * 19 / 20);
  CHECK(taken > bytes * 3 / 4);
  CHECK(fewer.surface->cells.size < 1.4 * small.size);
}

TEST_CASE("a budget of bytes takes faces away only where they may go and photographs do not fit") {
  BuildOptions options = with_face_loss(0);
  options.faces = {};
  options.planner = {};
  options.planner.min_view_gain = 0;
  const BuildResult all = build_model(fine_scene(), options);
  options.bound = Bound::of_gpu(all.gpu_bytes.sum() / 2);
  const BuildResult kept = build_model(fine_scene(), options);
  CHECK(faces_of(kept) == faces_of(all));
  options.faces.pixels = 1e-9;  // that alone takes no face away
  const BuildResult fewer = build_model(fine_scene(), options);
  CHECK(fewer.gpu_bytes.sum() <= options.bound.gpu_bytes());
  CHECK(faces_of(fewer) < faces_of(all) / 2);
  CHECK(fewer.scale > kept.scale);
  CHECK(fewer.gpu_bytes.photographs() > kept.gpu_bytes.photographs());
  CHECK(summary(fewer, options)["faces"]["taken_away"] == fewer.simplified_faces);
  CHECK(fewer.simplified_faces > 0);
  options.bound = Bound::of_gpu(2 * all.gpu_bytes.sum());
  CHECK(build_model(fine_scene(), options).simplified_faces < fewer.simplified_faces / 2);
}

TEST_CASE("where photographs were downscaled, the mesh is as coarse as they, if the bound on the loss allows it") {
  constexpr double kBound = 9;
  BuildOptions options = with_face_loss(kBound);
  const BuildResult result = build_model(fine_scene(), options);
  options.bound = Bound::of_loss(kBound, 0);
  const BuildResult finer = build_model(fine_scene(), options);
  CAPTURE(result.scale, faces_of(result), faces_of(finer));
  REQUIRE(result.scale < 1);
  CHECK(result.scale == finer.scale);
  CHECK(faces_of(result) < faces_of(finer));
  CHECK(finer.face_loss_db == 0);
  CHECK(result.face_loss_db != 0);
  CHECK(result.face_loss_db <= kBound);
  CHECK(result.parsimony->measured->mean_db <= kBound);
  CHECK(result.gpu_bytes.mesh < finer.gpu_bytes.mesh);
  CHECK(result.snapshot.cell_coverage.size() == result.snapshot.surface->cells.cells.size());
  CHECK(result.simplified_faces > finer.simplified_faces);
  CHECK(result.simplified_distance > finer.simplified_distance);
  const nlohmann::json totals = summary(result, result.options);
  CHECK(totals["faces"]["kept"] == faces_of(result));
  CHECK(totals["faces"]["taken_away"] == result.simplified_faces);
  CHECK(totals["parsimony"]["face_loss_db"] == result.face_loss_db);
  CHECK_THAT(parsimony_text(totals["parsimony"]), Catch::Contains(" with fewer faces too) of at most "));

  options.bound = Bound::of_loss(kBound, 1e-9);  // less than texels have lost already
  const BuildResult tried = build_model(fine_scene(), options);
  CHECK((tried.snapshot.surface->mesh.faces == finer.snapshot.surface->mesh.faces));
  CHECK(tried.face_loss_db == 0);
  CHECK(tried.simplified_faces == finer.simplified_faces);
  std::size_t compared = 0;
  for (std::size_t slot = 0; slot < tried.snapshot.views.size(); ++slot) {
    if (!tried.snapshot.views[slot] || !finer.snapshot.views[slot]) continue;  // nobody missed it
    ++compared;
    CHECK((tried.snapshot.views[slot]->mask->depth == finer.snapshot.views[slot]->mask->depth));
    CHECK((tried.snapshot.views[slot]->mask->validity == finer.snapshot.views[slot]->mask->validity));
  }
  CHECK(compared > 4);
}

TEST_CASE("faces go after photographs were downscaled, and of refined views") {
  BuildOptions options = with_face_loss(9);
  options.refine = RefineMode::all;
  options.least_scale = 0.5;
  const BuildResult result = build_model(fine_scene(), options);
  CHECK(result.scale < 1);
  CHECK(result.face_loss_db != 0);
  for (const auto& view : result.snapshot.views) {
    if (!view) continue;
    CHECK(view->camera.width == view->photograph->width());
    CHECK(view->mask->depth.size() == std::size_t{view->camera.width} * view->camera.height);
  }
}

TEST_CASE("bounds on the loss by faces are checked") {
  BuildOptions options = with_face_loss(0.1);
  options.bound = Bound::of_loss(0.1, std::numeric_limits<double>::quiet_NaN());
  CHECK_THROWS_WITH(build_model("/nowhere", options), Catch::Contains("face_loss_db is nan"));
  options.bound = Bound::of_loss(0, 0.1);
  options.planner.max_loss_db.reset();
  CHECK_THROWS_WITH(build_model("/nowhere", options), Catch::Contains("bound is on the loss, planner"));
}

}  // namespace
}  // namespace lumatlas
