// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/plan_city.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <utility>

#include "atlas/model/model_file.h"
#include "tools/base/process/interrupt.h"
#include "tools/pipeline/build_model.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// Refines the whole scene, or looks at it alone.
BuildResult build_whole(const fs::path& scene, const CityOptions& options, const BuildCallback& callback) {
  BuildOptions whole = options.build;
  whole.texture_px.reset();
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
  form.chunk_faces = block_faces;
  form.coarse = false;
  fs::create_directories(folder);
  write_model(folder, snapshot, {}, form);
}

// Fills in which photographs see which block. A photograph that sees a few of a block's pixels is listed: its planner
// decides whether that is worth a place.
void find_views(const ChunkedSurface& city, const BuildCallback& callback, CityPlan& plan) {
  std::vector<std::size_t> block_of_cell;
  for (std::size_t block = 0; block < plan.blocks.size(); ++block) {
    block_of_cell.insert(block_of_cell.end(), plan.blocks[block].size.cells, block);
  }
  const Surface surface = with_far_sphere(city.surface, city.far);
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(surface.mesh);
  BuildStage stage(callback, "looking through all cameras", plan.views.size());
  VisibilityBuffer buffer;
  for (std::size_t number = 0; number < plan.views.size(); ++number) {
    throw_if_interrupted();
    visibility->trace(plan.views[number].camera.shrunk_to(plan.build.planner.visibility_px), buffer);
    std::set<std::size_t> seen;
    for (const CellPixels& part : count_cell_pixels(buffer, surface.cells)) seen.insert(block_of_cell[part.cell]);
    for (const std::size_t block : seen) plan.blocks[block].views.push_back(number);
    stage.tick();
  }
  stage.finish();
}

std::vector<Bounds> boxes_of(const ChunkedSurface& city) {
  std::vector<Bounds> boxes;
  const Mesh& mesh = city.surface.mesh;
  std::size_t first = 0;
  for (const ChunkCounts& chunk : city.chunks) {
    Bounds box;
    for (const glm::uvec3& face : std::span(mesh.faces).subspan(first, chunk.faces)) {
      for (int corner = 0; corner < 3; ++corner) {
        const glm::dvec3 position(mesh.positions[face[corner]]);
        box.min = glm::min(box.min, position);
        box.max = glm::max(box.max, position);
      }
    }
    boxes.push_back(box);
    first += chunk.faces;
  }
  return boxes;
}

bool meet(const Bounds& a, const Bounds& b) {
  return glm::all(glm::lessThanEqual(a.min, b.max)) && glm::all(glm::lessThanEqual(b.min, a.max));
}

// Fills in which chunks a block's job reads: those in the box around the block, a cell's width about it, and the
// cameras that see it. Whatever stands between a camera and the block is in that box.
void find_chunks(const ChunkedSurface& city, CityPlan& plan) {
  const std::vector<Bounds> boxes = boxes_of(city);
  const glm::dvec3 margin(2 * city.surface.cells.size);
  for (std::size_t block = 0; block < boxes.size(); ++block) {
    Bounds box{boxes[block].min - margin, boxes[block].max + margin};
    for (const std::size_t view : plan.blocks[block].views) {
      const glm::dvec3 center = plan.views[view].camera.center();
      box.min = glm::min(box.min, center);
      box.max = glm::max(box.max, center);
    }
    std::vector<std::size_t>& chunks = plan.blocks[block].chunks;
    chunks.push_back(block);
    for (std::size_t other = 0; other < boxes.size(); ++other) {
      if (other != block && meet(box, boxes[other])) chunks.push_back(other);
    }
  }
  if (plan.blocks.size() == boxes.size()) return;
  plan.blocks.back().chunks.resize(boxes.size());  // those of the far sphere: all
  std::iota(plan.blocks.back().chunks.begin(), plan.blocks.back().chunks.end(), std::size_t{0});
}

}  // namespace

CityPlan plan_city(const fs::path& scene, const CityOptions& options, const fs::path& folder,
                   const BuildCallback& callback) {
  CityPlan plan;
  plan.scene = fs::absolute(scene).lexically_normal();
  plan.build = options.build;
  plan.hold_out = options.build.hold_out;
  plan.stamp = options.stamp;
  fs::create_directories(folder);
  const BuildResult whole = build_whole(scene, options, callback);
  plan.usual_distance = whole.effective.coverage.ideal_distance;
  plan.warnings = whole.warnings;
  take_views(whole, plan);
  write_surface(*whole.snapshot.surface, options.block_faces, surface_folder(folder));
  std::vector<std::size_t> all(count_chunks(surface_folder(folder)));
  std::iota(all.begin(), all.end(), std::size_t{0});
  const ChunkedSurface city = read_chunks(surface_folder(folder), all);
  for (const ChunkCounts& size : city.chunks) plan.blocks.push_back({false, size, {}, {}});
  if (const FarSphere& far = city.far; !far.mesh.faces.empty()) {
    const ChunkCounts size{far.cells.cells.size(), far.mesh.faces.size()};
    plan.blocks.push_back({true, size, {}, {}});
  }
  find_views(city, callback, plan);
  find_chunks(city, plan);
  write_city_plan(folder, plan);
  return plan;
}

}  // namespace lumatlas
