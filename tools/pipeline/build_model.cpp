// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/build_model.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>

#include "atlas/images/pixel_memory.h"
#include "mesh/base/errors.h"
#include "planner/surface_distance.h"
#include "tools/base/elapsed.h"
#include "tools/budget/fewer_faces.h"
#include "tools/budget/gpu_budget.h"
#include "tools/inspection/blind_views.h"
#include "tools/inspection/mesh_diagnosis.h"
#include "tools/pipeline/refinement/lens_notes.h"
#include "tools/pipeline/views/planned_views.h"
#include "tools/pipeline/views/streaming.h"
#include "tools/pipeline/watched_scene.h"
#include "tools/surface/surface_input.h"
#include "tools/texture/layout/texture_layout.h"

namespace lumatlas {

namespace {

std::vector<Camera> cameras_of(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks) {
  std::vector<Camera> cameras;
  cameras.reserve(ranks.size());
  for (const std::size_t rank : ranks) cameras.push_back(views[rank].camera);
  return cameras;
}

std::vector<std::size_t> offered_ranks(const SceneViews& scene, const std::optional<HoldOut>& hold_out) {
  std::vector<std::size_t> ranks = split(scene, hold_out).input;
  if (ranks.empty()) {
    throw InputError(scene.root.string() + ": none of its " + std::to_string(scene.views.size()) +
                     " views is left to build from: check --hold and --block");
  }
  return ranks;
}

// Returns the bytes of the photographs with all of their tiles, for as many of the largest as there may be.
std::uint64_t bytes_of_whole_photographs(const Stream& stream, const BuildOptions& options) {
  std::vector<std::uint64_t> tiles;
  for (const SceneView* view : stream) {
    tiles.push_back(TileGrid(view->camera.width, view->camera.height, options.tiles.tile_px).tiles());
  }
  std::sort(tiles.begin(), tiles.end(), std::greater<>());
  tiles.resize(std::min<std::size_t>(tiles.size(), options.max_views.value_or(~0u)));
  return place_bytes(options.tiles) * std::accumulate(tiles.begin(), tiles.end(), std::uint64_t{0});
}

// Returns whether the bytes of the GPU have room for all that the stream may bring.
bool all_fits(const Stream& stream, const BuildOptions& options, const SurfaceInput& input) {
  if (options.watch) return false;  // who knows
  return GpuByteCount(input.surface).of_surface() + bytes_of_whole_photographs(stream, options) <=
         options.bound.gpu_bytes();
}

// Before the first photograph is stored, because the tiles of the whole store are cut alike, and seen on one mesh.
void make_room(const Stream& stream, BuildOptions& options, SurfaceInput& input) {
  if (options.bound.gpu_bytes() == 0 || all_fits(stream, options, input)) return;
  if (options.tight_tiles) options.tiles = *options.tight_tiles;
  if (options.faces.pixels > 0) {
    const std::uint64_t photographs =
        options.watch ? options.bound.gpu_bytes() : bytes_of_whole_photographs(stream, options);
    input = with_room_for_photographs(input, options.cells, options.bound.gpu_bytes(), photographs);
  }
}

double median_distance(const std::filesystem::path& mesh_file, const std::vector<Camera>& cameras,
                       const Visibility& visibility) {
  try {
    return median_surface_distance(cameras, visibility);
  } catch (const InputError& error) {
    throw InputError(mesh_file.string() + ": " + error.what());
  }
}

void add_warning(const std::string& sentence, BuildResult& result) {
  if (!sentence.empty()) result.warnings.push_back(sentence);
}

void note_georeference(const SceneViews& scene, BuildResult& result) {
  const std::optional<GeoReference>& given = result.options.georeference;
  result.georeference = given ? given : scene.georeference;
  if (given) result.scene_notes.push_back("its coordinates are " + text_of(*given) + ", as --georeference says");
}

// Gives the model its position on the Earth, and warns where a tileset cannot say it.
void place_on_earth(BuildResult& result) {
  result.snapshot.georeference = result.georeference;
  add_warning(unplaced_warning(result.georeference).value_or(""), result);
}

void note_scene(const SceneViews& scene, BuildResult& result) {
  result.views = scene.views.size();
  result.listed_to_score = held_out_views(scene);
  result.masked_views = masked_views(scene);
  result.scene_notes = scene.notes;
  note_georeference(scene, result);
  result.skipped = skipped_views(scene.views);
}

void note_surface(const SurfaceInput& input, BuildResult& result) {
  result.closed_holes = input.closed_holes;
  result.simplified_faces = input.simplified_faces;
  result.simplified_distance = input.simplified_distance;
}

// Tells what does not fit. Lenses are then taken as given: what a wrong mesh pretends is no lens. Black borders are
// left out, before they are painted on the surface or taken for a lens.
void diagnose(const std::filesystem::path& scene, const MeshInput& mesh, const Visibility& visibility,
              std::vector<SceneView>& views, const std::vector<std::size_t>& ranks, const BuildCallback& callback,
              BuildResult& result) {
  BuildStage stage(callback, "comparing photographs over the mesh", 0);
  result.fit = diagnose_mesh(scene, mesh.facts, mesh.mesh, mesh.offset, visibility, views, ranks);
  for (const std::string& sentence : result.fit->warnings) add_warning(sentence, result);
  if (!result.fit->likely.empty()) result.options.refine_lenses = result.options.refine_shutters = false;
  if (result.fit->black_border > 0) leave_out_black_rims(views);
  stage.finish();
}

// Looks at the mesh as it was given, and tells what is wrong with it.
void judge(const std::filesystem::path& scene, const MeshInput& mesh, std::vector<SceneView>& views,
           const std::vector<std::size_t>& ranks, const BuildCallback& callback, BuildResult& result) {
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(mesh.mesh);
  const BlindViews blind = blind_views(views, ranks, *visibility);
  if (!result.options.watch) diagnose(scene, mesh, *visibility, views, ranks, callback, result);
  if (!result.options.any_mesh) {
    if (result.fit && !result.options.mesh_frame) require_right_frame(*result.fit);
    require_seen(result.mesh_file, blind, result.fit ? result.fit->likely : "");
  }
  add_warning(blind_views_warning(blind.blind, blind.looks, blind.first), result);
}

// Adds to the mesh what it lacks, and returns its far sphere, by which coverage counts only with demand: it is at no
// distance that a view could be ideal at. A mesh that does not fit the photographs stays as it is.
FarSphere complete(const std::filesystem::path& scene, const SceneViews& views, const std::vector<std::size_t>& ranks,
                   const BuildCallback& callback, MeshInput& mesh, BuildResult& result) {
  if (result.options.watch || (result.fit && !result.fit->likely.empty())) return {};
  CompletionOptions options = result.options.completion;
  options.far_sphere = options.far_sphere && has_demand(result.options.planner.coverage);
  CompletedSurface completed = complete_surface(scene, views, ranks, options, callback, mesh);
  result.frames = completed.shares;
  result.added_faces = completed.added_faces;
  result.faces_before = completed.faces_before;
  result.removed = {completed.contradicted.faces.size(), completed.contradicted.groups, completed.contradicted.pixels};
  for (const std::string& sentence : completed.warnings) add_warning(sentence, result);
  add_warning(filled_frames_warning(completed.shares), result);
  return std::move(completed.far);
}

// Some views of a scene, and what is known of them before there is a surface.
struct OfferedViews {
  SceneViews& views;
  const std::vector<std::size_t>& ranks;  // of those offered, the same for any order of the stream
  const Stream& stream;
  const FarSphere& far;  // without faces: there is none
  std::mt19937_64& random;
  WatchedScene* watched;  // null: the scene is complete
};

// Makes the surface that views are planned on, and plans them.
void plan_on(const OfferedViews& offered, MeshInput mesh, const BuildCallback& callback, const AtlasWatch& watch,
             BuildResult& result) {
  const BuildOptions& options = result.options;
  SeenSurface seen;
  SurfaceInput& input = seen.input;
  const std::vector<Camera> cameras = cameras_of(offered.views.views, offered.ranks);
  input = make_surface(std::move(mesh), options.cells, options.faces, cameras);
  make_room(offered.stream, result.options, input);
  note_surface(input, result);
  seen.visibility = make_visibility(*input.surface, options.visibility_by);
  double usual_distance = options.planner.coverage.ideal_distance;
  if (usual_distance == 0) usual_distance = median_distance(result.mesh_file, cameras, *seen.visibility);
  if (!offered.far.mesh.faces.empty()) {
    input.surface = std::make_shared<const Surface>(with_far_sphere(*input.surface, offered.far));
    seen.visibility = make_visibility(*input.surface, options.visibility_by);
  }
  plan_views({offered.views, offered.stream, seen, usual_distance, offered.random, offered.watched}, callback, watch,
             result);
}

// All but the base texture.
BuildResult choose_and_refine(const std::filesystem::path& scene, const BuildOptions& given,
                              const BuildCallback& callback, const AtlasWatch& watch) {
  BuildResult result;
  result.options = given;
  const BuildOptions& options = result.options;
  MeshInput mesh = load_mesh(scene, options.mesh, options.close_holes, options.mesh_frame.value_or(MeshFrame{}));
  std::optional<WatchedScene> watched_scene;
  if (options.watch) watched_scene.emplace(scene, mesh.offset, options.pictures, *options.watch);
  SceneViews views =
      watched_scene ? watched_scene->first_views() : read_scene_views(scene, mesh.offset, options.pictures);
  note_scene(views, result);
  const std::vector<std::size_t> ranks = offered_ranks(views, options.hold_out);
  std::mt19937_64 random(options.seed);
  const Stream stream = stream_of(views.views, in_order(ranks, options.order, random));
  require_names_that_a_model_can_hold(stream);
  result.mesh_file = mesh.facts.mesh_file;
  result.warnings = mesh.facts.warnings;
  judge(scene, mesh, views.views, ranks, callback, result);
  const FarSphere far = complete(scene, views, ranks, callback, mesh, result);
  plan_on({views, ranks, stream, far, random, watched_scene ? &*watched_scene : nullptr}, std::move(mesh), callback,
          watch, result);
  result.scene_views = std::move(views.views);
  return result;
}

BuildResult choose_and_refine(PosedScene& scene, const BuildOptions& given, const BuildCallback& callback,
                              const AtlasWatch& watch) {
  BuildResult result;
  result.options = given;
  if (given.completion.surface || given.watch) {
    throw std::invalid_argument("build: a scene without a folder is neither completed by stereo nor watched");
  }
  note_scene(scene.views, result);
  std::mt19937_64 random(given.seed);
  const Stream stream = stream_of(scene.views.views, in_order(scene.offered, given.order, random));
  if (stream.empty()) throw InputError(scene.views.root.string() + ": has no view to build from");
  require_names_that_a_model_can_hold(stream);
  result.mesh_file = scene.mesh.facts.mesh_file;
  result.warnings = scene.mesh.facts.warnings;
  std::vector<std::size_t> ranks = scene.offered;
  std::sort(ranks.begin(), ranks.end());
  const FarSphere far = complete(scene.views.root, scene.views, ranks, callback, scene.mesh, result);
  plan_on({scene.views, ranks, stream, far, random, nullptr}, std::move(scene.mesh), callback, watch, result);
  result.scene_views = std::move(scene.views.views);
  return result;
}

void add_texture(const BuildCallback& callback, BuildResult& result) {
  const auto& views = result.snapshot.views;
  const bool stored = std::any_of(views.begin(), views.end(), [](const auto& view) { return view != nullptr; });
  if (!result.options.texture_px || !stored) return;
  try {
    result.texture = bake_texture(result.snapshot, *result.options.texture_px, callback);
  } catch (const ChartsDoNotFit& error) {
    add_warning(std::string("other programs show averaged colours instead of a texture: ") + error.what(), result);
  }
}

template <typename Scene>
BuildResult build_from(Scene& scene, const BuildOptions& options, const BuildCallback& callback,
                       const AtlasWatch& watch) {
  const auto start = std::chrono::steady_clock::now();
  check(options);
  const auto memory = std::make_shared<const PixelMemoryBound>(
      options.memory.bytes.value_or(usual_pixel_memory()),
      options.memory.scratch_folder.empty() ? std::filesystem::temp_directory_path() : options.memory.scratch_folder);
  BuildResult result = choose_and_refine(scene, options, callback, watch);
  result.memory = memory;
  place_on_earth(result);
  add_texture(callback, result);  // with the memory that planning took
  result.scratch_bytes = pixel_memory().in_files;
  result.total_ms = ms_since(start);
  return result;
}

}  // namespace

BuildResult build_model(const std::filesystem::path& scene, const BuildOptions& options, const BuildCallback& callback,
                        const AtlasWatch& watch) {
  return build_from(scene, options, callback, watch);
}

BuildResult build_model(PosedScene scene, const BuildOptions& options, const BuildCallback& callback,
                        const AtlasWatch& watch) {
  return build_from(scene, options, callback, watch);
}

}  // namespace lumatlas
