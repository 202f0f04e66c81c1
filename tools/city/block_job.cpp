// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/block_job.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "atlas/images/pixel_memory.h"
#include "atlas/model/model_file.h"
#include "mesh/base/errors.h"
#include "tools/base/elapsed.h"
#include "tools/base/output_folder.h"
#include "tools/base/strict_json.h"
#include "tools/city/city_surface.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/pipeline/views/planned_views.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kJobName = "city block";  // the command of the folder's marker file

// Returns the views of the scene that see the block, with the plan's poses and lenses.
SceneViews placed_views(const CityPlan& plan, const CityBlock& block, const glm::dvec3& offset) {
  SceneViews scene = read_scene_views(plan.scene, offset, plan.build.pictures);
  std::map<std::string, const SceneView*> by_name;
  for (const SceneView& view : scene.views) by_name[view.name] = &view;
  std::vector<SceneView> placed;
  for (const std::size_t number : block.views) {
    const CityView& wanted = plan.views[number];
    const auto found = by_name.find(wanted.name);
    if (found == by_name.end()) {
      throw InputError(plan.scene.string() + ": has no photograph " + wanted.name +
                       " any more, which was there when the city was planned: plan it again");
    }
    SceneView view = *found->second;
    view.camera = wanted.camera;
    view.correction = wanted.correction;
    view.motion = wanted.motion;
    view.black_rim = wanted.black_rim;
    placed.push_back(std::move(view));
  }
  scene.views = std::move(placed);
  return scene;
}

// Poses, lenses and exposures are the plan's; what photographs contradict is masked, as `build` does.
BuildOptions job_options(const CityPlan& plan) {
  BuildOptions options = plan.build;
  options.refine = RefineMode::all;
  options.refine_lenses = options.refine_shutters = false;
  options.planner.refinement.alignment.pose = false;
  std::map<std::string, glm::dvec3> gains;
  for (const CityView& view : plan.views) gains[view.name] = view.gain;
  options.planner.refinement.given_gain = [gains = std::move(gains)](const std::string& name) {
    return gains.at(name);
  };
  options.texture_px.reset();
  return options;
}

// Cells of other blocks have their references, and the tiles for these, in their own blocks.
void drop_references_of_others(const CityBlock& block, Atlas& atlas) {
  const std::size_t cells = atlas.surface()->cells.cells.size(), own = block.size.cells;
  AtlasEdit edit;
  for (std::size_t cell = block.far ? 0 : own; cell < (block.far ? cells - own : cells); ++cell) {
    edit.set_references(CellId(static_cast<std::uint32_t>(cell)), {});
  }
  atlas.commit(std::move(edit));
}

// Returns the surface that the job plans views on.
Surface surface_of_job(const fs::path& folder, const CityPlan& plan, const CityBlock& block) {
  ChunkedSurface around = CitySurface(folder).read(block.chunks);
  around.surface.cells.size = plan.cell_size;
  if (!block.far) return std::move(around.surface);
  Surface& near = around.surface;
  near.cells = measure_cells(near.mesh, std::vector<CellId>(near.mesh.faces.size(), CellId(0)), near.cells.size);
  return with_far_sphere(near, around.far);
}

BuildResult plan_block(const fs::path& folder, const CityPlan& plan, const CityBlock& block,
                       const BuildCallback& callback) {
  BuildResult result;
  result.options = job_options(plan);
  SeenSurface seen;
  seen.input.surface = std::make_shared<const Surface>(surface_of_job(folder, plan, block));
  seen.input.mesh_file = surface_folder(folder);
  seen.visibility = make_visibility(*seen.input.surface, result.options.visibility_by);
  SceneViews views = placed_views(plan, block, seen.input.surface->offset);
  std::mt19937_64 random(result.options.seed);
  plan_views({views, stream_of(views.views), seen, plan.usual_distance, random, nullptr,
              [&block](Atlas& atlas) { drop_references_of_others(block, atlas); }},
             callback, {}, result);
  return result;
}

// Returns the model of a block that no photograph sees.
BuildResult unseen_block(const fs::path& folder, const CityPlan& plan, const CityBlock& block) {
  BuildResult result;
  result.snapshot.surface = std::make_shared<const Surface>(surface_of_job(folder, plan, block));
  const Surface& surface = *result.snapshot.surface;
  const std::size_t cells = surface.cells.cells.size(), vertices = surface.mesh.positions.size();
  result.snapshot.references.offsets.assign(cells + 1, 0);
  result.snapshot.cell_seen.assign(cells, 0);
  result.snapshot.vertex_colors = FallbackColors::Colors(vertices, glm::u8vec3(128));
  result.snapshot.tiles.options = kWholeViews;
  return result;
}

// Removes a block whose marker is gone: a workflow engine removes it of a job that it takes for failed, also where the
// block was complete by then. The folder is the plan's own.
void remove_unmarked(const fs::path& block) {
  std::error_code ignored;
  if (fs::exists(block, ignored) && !fs::exists(block / kMarkerFile, ignored)) fs::remove_all(block);
}

}  // namespace

bool is_block_done(const fs::path& folder, const CityPlan& plan, std::size_t block) {
  const fs::path marker = block_folder(folder, block) / kMarkerFile;
  std::error_code ignored;
  if (!fs::is_regular_file(marker, ignored)) return false;
  const json written = read_json(marker);
  return written.value("command", "") == kJobName && written.contains("options") &&
         written["options"].value("stamp", "") == plan.stamp;
}

BlockFacts build_block(const fs::path& folder, const CityPlan& plan, std::size_t number,
                       const BuildCallback& callback) {
  if (number >= plan.blocks.size()) {
    throw std::invalid_argument("city: block " + std::to_string(number) + " is asked for, must be below " +
                                std::to_string(plan.blocks.size()));
  }
  const auto start = std::chrono::steady_clock::now();
  const CityBlock& block = plan.blocks[number];
  fs::create_directories(block_folder(folder, number).parent_path());
  remove_unmarked(block_folder(folder, number));
  OutputFolder output(block_folder(folder, number), kJobName);
  const PixelMemoryBound memory(std::min(usual_pixel_memory(), plan.memory / kPixelShare), scratch_folder_for(folder));
  const BuildResult result =
      block.views.empty() ? unseen_block(folder, plan, block) : plan_block(folder, plan, block, callback);
  FormOptions form;
  form.coarse_faces = 0;
  write_model(output.path(), result.snapshot, result.effective.validity, form);
  output.commit({{"stamp", plan.stamp}, {"block", number}});
  BlockFacts facts;
  facts.offered = block.views.size();
  facts.stored = static_cast<std::size_t>(std::count_if(result.snapshot.views.begin(), result.snapshot.views.end(),
                                                        [](const auto& view) { return view != nullptr; }));
  facts.resident_tiles = result.snapshot.tiles.resident_tiles();
  facts.total_ms = ms_since(start);
  return facts;
}

}  // namespace lumatlas
