// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/plan_city.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "atlas/model/model_file.h"
#include "planner/surface_distance.h"
#include "tools/city/block_cut.h"
#include "tools/pipeline/build_model.h"
#include "tools/stereo/scene_stereo.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// Returns the size that cells of a city have. `build` divides a scene by its diameter, but a city is larger than what
// any photograph shows, so that the distance of the cameras bounds the size too.
double cell_size(const fs::path& scene, const BuildOptions& build) {
  constexpr double kShareOfDistance = 0.085;  // 1/60 of the diameter of a village seen from the air
  const MeshInput mesh = load_mesh(scene, build.mesh, build.close_holes, build.mesh_frame.value_or(MeshFrame{}));
  const SceneViews views = read_scene_views(scene, mesh.offset, build.pictures);
  std::vector<Camera> cameras;
  for (const std::size_t rank : split(views, build.hold_out).input) cameras.push_back(views.views[rank].camera);
  const double distance = median_surface_distance(cameras, *make_ray_visibility(mesh.mesh));
  return std::min(automatic_cell_size(mesh.mesh), kShareOfDistance * distance);
}

// Refines the whole scene, or looks at it alone.
BuildResult build_whole(const fs::path& scene, const CityOptions& options, const fs::path& folder,
                        const BuildCallback& callback) {
  BuildOptions whole = options.build;
  whole.completion.stereo_folder = folder / "stereo";
  whole.texture_px.reset();
  if (whole.cells.size == 0) whole.cells.size = cell_size(scene, whole);
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

CityView city_view(const SceneView& view) {
  return {view.name, view.camera, view.correction, glm::dvec3(1.0), view.black_rim};
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

// Writes the surface as a model without photographs.
void write_surface(const Surface& whole, std::size_t block_faces, const fs::path& folder) {
  Snapshot snapshot;
  snapshot.surface = std::make_shared<const Surface>(whole);
  const Surface& surface = *snapshot.surface;
  snapshot.references.offsets.assign(surface.cells.cells.size() + 1, 0);
  snapshot.cell_seen.assign(surface.cells.cells.size(), 0);
  snapshot.vertex_colors = FallbackColors::Colors(surface.mesh.positions.size(), glm::u8vec3(128));
  snapshot.tiles.options = kWholeViews;
  FormOptions form;
  form.chunk_faces = std::max<std::size_t>(1, block_faces / kChunksPerBlock);
  form.coarse_faces = 0;
  fs::create_directories(folder);
  write_model(folder, snapshot, {}, form);
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
  plan.stamp = options.stamp;
  open_plan_folder(folder);
  const BuildResult whole = build_whole(scene, options, folder, callback);
  plan.usual_distance = whole.effective.coverage.ideal_distance;
  plan.warnings = whole.warnings;
  plan.georeference = whole.georeference;
  take_views(whole, plan);
  write_surface(*whole.snapshot.surface, options.block_faces, surface_folder(folder));
  std::vector<std::size_t> all(count_chunks(surface_folder(folder)));
  std::iota(all.begin(), all.end(), std::size_t{0});
  cut_into_blocks(read_chunks(surface_folder(folder), all), options.block_faces, callback, plan);
  write_city_plan(folder, plan);
  remove_stereo_work(folder / "stereo");
  return plan;
}

}  // namespace lumatlas
