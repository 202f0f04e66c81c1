// SPDX-License-Identifier: GPL-3.0-or-later
// The main job: a scene's photographs, offered to the planner one by one, become a model.
//
// Only photographs that are to be stored are read. Only the size of the others is read: one that is cut off or damaged
// behind its header is not noticed, and does no harm. A few are read beforehand, to see whether the mesh fits them:
// tools/inspection/mesh_diagnosis.h.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "blend/gpu_bytes.h"
#include "mesh/cells/cells.h"
#include "planner/offline_planner.h"
#include "planner/planner.h"
#include "planner/pruning/pruning.h"
#include "tools/budget/build_progress.h"
#include "tools/budget/measured_loss.h"
#include "tools/inspection/mesh_diagnosis.h"
#include "tools/pipeline/build_options.h"
#include "tools/pipeline/surface/baked_texture.h"
#include "tools/pipeline/surface/completed_surface.h"
#include "tools/pipeline/surface/surface_trust_shares.h"
#include "tools/pipeline/view_stream.h"
#include "tools/scene/scene.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

// The correction of a lens that the photographs suggest, and whether it was made.
struct RefinedLens {
  Camera camera;          // its size, focal lengths and principal point
  std::size_t views = 0;  // stored ones
  // The last one that was applied, with all that was as its correction, and the residual before of the first, which
  // with RefineMode::all had fewer views.
  LensEstimate estimate;
  bool applied = false;  // the photographs were undistorted again
};

// The motions of cameras while their shutters read the photographs, and whether these were straightened.
struct RefinedShutters {
  // The last one that was applied, else the first; its residual before is that of the first.
  ShutterEstimate estimate;
  double median_px = 0;                          // median of edge_move_px() of all motions that were applied
  std::map<std::string, ShutterMotion> motions;  // by the views' names, of points at the depth 1; empty: not applied
  bool applied = false;
};

// A photograph that was left out because it is bad, and why: see PictureFolders::skip_bad, WatchOptions.
struct SkippedView {
  std::string name, why;
};

// The result for one offered view.
struct PlannedView {
  std::string name;
  // `rejected`, and nothing else, for a view whose photograph was not read. A view that lost its place again before its
  // photograph was read counts as kept, or replaced, as it was decided then; its `slot` is another view's.
  Verdict verdict;
  double read_ms = 0;          // wall time of reading the photograph; 0: it was not read
  double summed_coverage = 0;  // scov afterwards, in cells
};

// The choice that the offline planner made, and what it cost.
struct OfflinePlan {
  OfflineChoice choice;  // views by their place in the stream
  double look_ms = 0;    // through all cameras
  double choose_ms = 0;
};

// For PlannerOptions::max_loss_db: the views given up, and the size of a store of all offered views except outliers.
struct Parsimony {
  PredictedLoss predicted;  // predicted from coverage
  std::optional<MeasuredLoss>
      measured;        // the loss by all that was given up after the stream; none: nothing was measured
  double loss_db = 0;  // in all: what was measured, and what of the rest is predicted; without the former as predicted
  std::vector<std::string> taken_away;  // once the stream had ended, in that order
  std::size_t views = 0;
  std::uint64_t references = 0;  // one for each cell and each view that sees it
  std::uint64_t gpu_bytes = 0;   // all that was stored when the stream had ended, before anything was given up
};

// Faces of the mesh that photographs contradict (tools/meshing/contradicted_faces.h).
struct RemovedFaces {
  std::size_t faces = 0, groups = 0;
  double pixels = 0;  // share of the pixels of the matched photographs that see the mesh, [0, 1]
};

struct BuildResult {
  Snapshot snapshot;
  GpuBytes gpu_bytes;  // the snapshot's, as its model file holds it
  double scale = 1;    // scale of a photograph's sides, see BuildOptions::least_scale
  std::optional<MeasuredLoss>
      fitted_loss;                   // the loss by `scale`, and by tiles that the bound has no room for: FittedViews
  std::vector<PlannedView> planned;  // in the order of the stream
  std::filesystem::path mesh_file;
  BuildOptions options;                      // the given ones; `tiles` are those that were taken
  std::uint64_t closed_holes = 0;            // in the mesh
  std::uint64_t simplified_faces = 0;        // SurfaceInput::simplified_faces, and
  double simplified_distance = 0;            // its distance
  std::vector<std::string> warnings;         // sentences that `lumatlas inspect` would print too
  std::optional<TrustShares> trust;          // none if BuildOptions::measure_deviation is off
  std::optional<FrameShares> frames;         // the offered photographs' shares; none if complete_surface() did not look
  std::size_t added_faces = 0;               // faces that complete_surface() added to the mesh
  std::size_t faces_before = 0;              // those of them that stand before the mesh
  RemovedFaces removed;                      // faces that complete_surface() removed from the mesh
  std::optional<MeshDiagnosis> fit;          // the fit of mesh and photographs; none for a watched scene
  std::vector<SkippedView> skipped;          // sorted by name
  std::vector<std::string> scene_notes;      // sentences: what was assumed of the scene, see SceneViews::notes
  std::optional<GeoReference> georeference;  // of BuildOptions, else SceneViews; the snapshot has it too
  std::vector<SceneView> scene_views;        // the scene's, with what was found of their lenses and shutters
  std::size_t views = 0, masked_views = 0;   // in the scene
  std::size_t listed_to_score = 0;           // how many of these are SceneView::held_out
  PlannerOptions effective;                  // with every automatic value filled in, its masks those of the snapshot
  std::optional<OfflinePlan> offline;        // for ViewChoice::offline
  std::optional<Parsimony> parsimony;        // for planner.max_loss_db
  double texel_loss_db = 0;         // with a bound on it: about the loss by texels as they are now, with all else
  double face_loss_db = 0;          // with a bound on it: about the loss by faces too, with all views; 0: none went
  std::vector<RefinedLens> lenses;  // empty: lenses were not refined
  std::optional<RefinedShutters> shutters;  // none: they were not looked at
  double summed_coverage = 0;
  std::uint64_t stored_bytes = 0;  // all stored views', as planner/planner.h counts them
  // For RefineMode::joint: its steps, and all poses at once where they were solved for.
  std::vector<PolishStep> polish;
  std::optional<PoseEstimate> poses;
  double polish_ms = 0;
  std::uint64_t revisited = 0;  // see Refiner::revisited()
  // For BuildOptions::texture_px. None without a stored view, or if there are more charts than it has room for, which a
  // warning tells.
  std::optional<BakedTexture> texture;
  std::uint64_t scratch_bytes = 0;                 // of photographs and masks, in scratch files at the end
  std::shared_ptr<const PixelMemoryBound> memory;  // by MemoryOptions, as long as the result lives
  double total_ms = 0;
};

// Called when the stream is about to begin, with the atlas that it fills. Its result is destroyed before the last
// snapshot is taken. Snapshots taken meanwhile, from any thread, do not change the result.
using AtlasWatch = std::function<std::shared_ptr<void>(const Atlas&)>;

// Checks the options before it reads anything, and that each view alone fits into planner.max_bytes before it plans
// anything. Writes nothing, to no stream either; tools/pipeline/output/save_model.h writes the result. Throws
// InputError, what check() throws, with VisibilityBy::gl GlError, and BuildStopped once the callback has returned
// false.
[[nodiscard]] BuildResult build_model(const std::filesystem::path& scene, const BuildOptions& options,
                                      const BuildCallback& callback = {}, const AtlasWatch& watch = {});

// A scene that the caller holds, in place of a folder.
struct PosedScene {
  SceneViews views;                  // relative to mesh.offset
  std::vector<std::size_t> offered;  // ranks of views, in the order in which they are offered; at least one
  MeshInput mesh;                    // not compared with photographs; may get a far sphere, see completion.far_sphere
};

// Builds a model of a scene that the caller holds. options.order takes `offered` as given; options.mesh, mesh_frame
// and close_holes have no effect, and hold_out is only recorded. Throws as the function above, and
// std::invalid_argument with completion.surface or watch, which need a folder.
[[nodiscard]] BuildResult build_model(PosedScene scene, const BuildOptions& options, const BuildCallback& callback = {},
                                      const AtlasWatch& watch = {});

}  // namespace lumatlas
