// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/planning/plan_city.h"

#include <algorithm>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <span>
#include <utility>

#include "planner/surface_distance.h"
#include "tools/city/city_surface.h"
#include "tools/city/planning/block_cut.h"
#include "tools/city/planning/city_cells.h"
#include "tools/city/planning/plan_in_pieces.h"
#include "tools/pipeline/build_model.h"
#include "tools/stereo/scene_stereo.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

double whole_cell_size(const fs::path& scene, const BuildOptions& build) {
  const MeshInput mesh = load_mesh(scene, build.mesh, build.close_holes, build.mesh_frame.value_or(MeshFrame{}));
  const SceneViews views = read_scene_views(scene, mesh.offset, build.pictures);
  std::vector<Camera> cameras;
  for (const std::size_t rank : split(views, build.hold_out).input) cameras.push_back(views.views[rank].camera);
  return city_cell_size(mesh.mesh, median_surface_distance(cameras, *make_ray_visibility(mesh.mesh)));
}

// Refines the whole scene, or looks at it alone.
BuildResult build_whole(const fs::path& scene, const CityOptions& options, const fs::path& folder,
                        const BuildCallback& callback) {
  BuildOptions whole = options.build;
  whole.completion.stereo_folder = folder / "stereo";
  whole.texture_px.reset();
  if (whole.cells.size == 0) whole.cells.size = whole_cell_size(scene, whole);
  whole.measure_deviation = false;
  whole.max_views.reset();
  if (whole.refine == RefineMode::none) {
    whole.max_views = 1;  // the surface and the cameras are what is needed
  } else {
    whole.refine = RefineMode::joint;
    whole.planner.min_view_gain = 0;
  }
  return build_model(scene, whole, callback);
}

// Fills in the views, as they were refined.
void take_views(const BuildResult& whole, CityPlan& plan) {
  const bool refined = whole.options.refine != RefineMode::none;
  std::map<std::string, std::size_t> stored;
  for (std::size_t slot = 0; slot < whole.snapshot.views.size(); ++slot) {
    if (whole.snapshot.views[slot]) stored[whole.snapshot.views[slot]->name] = slot;
  }
  std::set<std::string> offered;
  for (const PlannedView& planned : whole.planned) offered.insert(planned.name);
  for (const SceneView& view : whole.scene_views) {
    if (!offered.contains(view.name)) continue;
    CityView taken = city_view(view);
    const auto found = stored.find(view.name);
    if (refined && found == stored.end()) {
      plan.left_out.push_back(view.name);
      continue;
    }
    if (refined) {
      taken.camera = whole.snapshot.views[found->second]->camera;
      taken.gain = whole.snapshot.gains[found->second];
    }
    plan.views.push_back(std::move(taken));
  }
}

// Plans with the whole surface in memory, which completing it and refining poses need.
void plan_whole(const fs::path& scene, const CityOptions& options, const fs::path& folder,
                const BuildCallback& callback, CityPlan& plan) {
  const BuildResult whole = build_whole(scene, options, folder, callback);
  plan.usual_distance = whole.effective.coverage.ideal_distance;
  plan.warnings = whole.warnings;
  plan.georeference = whole.georeference;
  take_views(whole, plan);
  write_surface_piece(folder, 0, *whole.snapshot.surface, chunk_faces_for(options.block_faces));
  const CitySurface written(folder);
  std::vector<std::size_t> all(written.count());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const ChunkedSurface city = written.read(all);
  plan.cell_size = city.surface.cells.size;
  plan.chunks = describe_chunks(city);
  const Surface surface = with_far_sphere(city.surface, city.far);
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(surface.mesh);
  const LookAtCity look = [&](std::span<const Camera> cameras, const auto& use) {
    VisibilityBuffer buffer;
    for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
      visibility->trace(cameras[camera], buffer);
      use(camera, buffer);
    }
  };
  cut_into_blocks({look, surface.cells.cell_of_face, {surface.far_cells, surface.far_faces}}, options.block_faces,
                  callback, plan);
}

}  // namespace

CityPlan plan_city(const fs::path& scene, const CityOptions& options, const fs::path& folder,
                   const BuildCallback& callback) {
  CityPlan plan;
  plan.scene = fs::absolute(scene).lexically_normal();
  plan.build = options.build;
  for (std::optional<fs::path>* pictures : {&plan.build.pictures.images, &plan.build.pictures.masks}) {
    if (*pictures) *pictures = fs::absolute(**pictures).lexically_normal();
  }
  plan.hold_out = options.build.hold_out;
  plan.memory = options.memory;
  plan.stamp = options.stamp;
  open_plan_folder(folder);
  clear_surface(folder);
  if (can_plan_in_pieces(options)) {
    plan_in_pieces(scene, options, folder, callback, plan);
  } else {
    plan_whole(scene, options, folder, callback, plan);
  }
  write_city_plan(folder, plan);
  remove_stereo_work(folder / "stereo");
  return plan;
}

}  // namespace lumatlas
