// SPDX-License-Identifier: GPL-3.0-or-later
// The main job: a scene's photographs, offered to the planner one by one, become a model.
//
// Only photographs that are to be stored are read. Of the others the size is looked at and no more: one of them that is
// cut off or damaged behind its header is not noticed, and does no harm.
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
#include "mesh/cells.h"
#include "planner/offline_planner.h"
#include "planner/planner.h"
#include "tools/pipeline/baked_texture.h"
#include "tools/pipeline/build_progress.h"
#include "tools/pipeline/view_stream.h"
#include "tools/scene/scene.h"
#include "tools/scene/surface_input.h"

namespace lumatlas {

// Bytes of photographs to choose tiles from, for each that tiles may take on the GPU.
inline constexpr std::uint64_t kPhotographsPerArray = 4;
// So many for tiles that take those bytes; of compressed tiles, for what they would take uncompressed.
[[nodiscard]] std::uint64_t photograph_bytes_for(std::uint64_t tile_bytes, const TileOptions& tiles);

// What is made to agree before a view is stored: see planner/refiner.h.
enum class RefineMode {
  none,
  exposure,  // gains
  pose,      // poses, gains stay 1
  all,       // gains, poses, and masks of what the other views contradict
  joint,     // and afterwards all stored views together, until they rest
};

// Who chooses the views that are stored. All but the first are there to compare it with: they choose before anything is
// stored.
enum class ViewChoice {
  online,   // the planner, view by view
  offline,  // the offline planner, which looks through all cameras first: see planner/offline_planner.h
  uniform,  // nobody: views evenly spaced along the stream
  random,   // nobody: by chance
};

// What finds the visible surface; the two agree but at silhouettes.
enum class VisibilityBy {
  rays,  // mesh/visibility.h, on the processor
  gl,    // blend/gl_visibility.h, on the GPU that EGL finds, else on Mesa's software driver
};

// A scene whose folder fills up while the model is built: see tools/scene/growing_scene.h. What cannot be read is
// named, and the build goes on. Cells, and what else depends on all cameras, are as those ask that are listed when the
// first photograph has come. Joint refinement, and what else looks at all views, comes at the end.
struct WatchOptions {
  std::chrono::milliseconds interval{1000};  // between two looks at the folder, > 0
  // The end of the stream: so long after the last change, or, asked some times a second, when this says so. One is
  // given.
  std::optional<std::chrono::milliseconds> idle;
  std::function<bool()> end;
  std::function<void(const std::string&)> warn;  // told, at once, what is wrong with files, in sentences; or empty
};

struct BuildOptions {
  std::optional<std::filesystem::path> mesh;  // none: looked for beside the scene
  PictureFolders pictures;                    // photographs and masks
  CellOptions cells;
  FaceOptions faces;       // of the mesh that are kept
  double close_holes = 0;  // holes of the mesh up to this across are closed, scene units, >= 0
  VisibilityBy visibility_by = VisibilityBy::rays;
  // coverage.ideal_distance 0: the median camera-surface distance of the scene; max_loss_db needs ViewChoice::online
  PlannerOptions planner;
  RefineMode refine = RefineMode::joint;         // switches off what planner.refinement has on, never on
  std::uint32_t max_polish_steps = 15;           // of RefineMode::joint, >= 1
  bool refine_lenses = true;                     // of RefineMode::joint: see planner/lens_estimate.h
  std::optional<std::uint32_t> max_views = 100;  // N, >= 1; none: bounded by planner.max_bytes alone
  TileOptions tiles;                             // max_tiles: 0, for array_bytes says it
  // Instead of `tiles`, where gpu_bytes has no room for the photographs whole, all of them or the largest max_views, or
  // where nobody knows them, with `watch`; none: `tiles` all the same. Both cut views into tiles.
  std::optional<TileOptions> tight_tiles;
  std::uint64_t array_bytes = 0;  // that the texture array of tiles may take; 0: what it needs
  // That the model may take on the GPU, mesh and tables included: see gpu_budget.h. 0: what it needs. Not with
  // array_bytes. Without max_views and planner.max_bytes, the planner holds four times the photographs that there is
  // room for, to choose tiles from.
  std::uint64_t gpu_bytes = 0;
  // Of a photograph's sides, the share that gpu_bytes and max_scale_loss_db may downscale all photographs to, (0, 1],
  // the former before it gives up parts of some: see downscaled_views.h.
  double least_scale = 0.25;
  // With planner.max_loss_db, not with gpu_bytes: all photographs are downscaled as far as that costs at most so many
  // dB, finite and >= 0, by measurement; 0: not at all.
  double max_scale_loss_db = 0;
  // The longest side of the texture that other programs show, [kLeastTexturePx, kMostTexturePx]; none: they show the
  // averaged colours of vertices.
  std::optional<std::uint32_t> texture_px = 2048;
  std::optional<HoldOut> hold_out;  // none: every view is offered
  // None: what is there is all. Needs ViewChoice::online, StreamOrder::given (photographs are offered as they come,
  // those that come together by name), no hold_out, for which all names must be known, and a bound: max_views,
  // planner.max_bytes or gpu_bytes.
  std::optional<WatchOptions> watch;
  bool any_mesh = false;  // build also where most views see next to nothing of the mesh, which is refused otherwise
  StreamOrder order = StreamOrder::given;
  // With another choice than online, planner.max_bytes counts as so many of the largest view.
  ViewChoice choice = ViewChoice::online;
  std::uint64_t seed = 0;  // of StreamOrder::shuffled and ViewChoice::random
};

// What the photographs say about a lens, and whether it was done.
struct RefinedLens {
  Camera camera;          // its size, focal lengths and principal point
  std::size_t views = 0;  // stored ones
  LensEstimate estimate;  // with all that was applied as its correction, and residuals from before to after
  bool applied = false;   // the photographs were undistorted again
};

// A photograph that was left out because it is bad, and why: see PictureFolders::skip_bad, WatchOptions.
struct SkippedView {
  std::string name, why;
};

// What became of one view that was offered.
struct PlannedView {
  std::string name;
  Verdict verdict;             // of a view that nobody looked at: rejected, and nothing else
  double read_ms = 0;          // wall time of reading the photograph; 0: it was not read
  double summed_coverage = 0;  // scov afterwards, in cells
};

// The choice that the offline planner made, and what it cost.
struct OfflinePlan {
  OfflineChoice choice;  // views by their place in the stream
  double look_ms = 0;    // through all cameras
  double choose_ms = 0;
};

// Of PlannerOptions::max_loss_db: what was given up, and what all offered views but outliers would have been.
struct Parsimony {
  PredictedLoss predicted;
  std::vector<std::string> taken_away;  // once the stream had ended, in that order
  std::size_t views = 0;
  std::uint64_t references = 0;  // of each cell to each view that sees it
  std::uint64_t texels = 0;      // of whole photographs; of tiles, all of them, gutters included
};

struct BuildResult {
  Snapshot snapshot;
  GpuBytes gpu_bytes;                // of the snapshot, as its model file holds it
  double scale = 1;                  // of a photograph's sides, the share that is kept, see BuildOptions::least_scale
  std::vector<PlannedView> planned;  // in the order of the stream
  std::filesystem::path mesh_file;
  BuildOptions options;                     // as they were given; `tiles` are those that were taken
  std::uint64_t closed_holes = 0;           // of the mesh
  std::uint64_t simplified_faces = 0;       // SurfaceInput::simplified_faces, and
  double simplified_distance = 0;           // its distance
  std::vector<std::string> warnings;        // what `lumatlas inspect` would warn of too, in sentences
  std::vector<SkippedView> skipped;         // by name
  std::vector<std::string> scene_notes;     // sentences: what was assumed of the scene, see SceneViews::notes
  std::size_t views = 0, masked_views = 0;  // of the scene
  PlannerOptions effective;                 // with every automatic value filled in, its masks those of the snapshot
  std::optional<OfflinePlan> offline;       // of ViewChoice::offline
  std::optional<Parsimony> parsimony;       // of planner.max_loss_db
  double scale_loss_db = 0;                 // of `scale`, as measured for max_scale_loss_db
  std::vector<RefinedLens> lenses;          // empty: nobody asked
  double summed_coverage = 0;
  std::uint64_t stored_bytes = 0;  // of all stored views, as planner/planner.h counts them
  std::vector<PolishStep> polish;  // of RefineMode::joint
  double polish_ms = 0;
  std::uint64_t revisited = 0;  // see Refiner::revisited()
  // Of BuildOptions::texture_px; none without a stored view, or where there are more charts than it has room for, of
  // which a warning tells.
  std::optional<BakedTexture> texture;
  double total_ms = 0;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const BuildOptions& options);

// Called when the stream is about to begin, with the atlas that it fills; what it gives is destroyed before the last
// snapshot is taken. Whoever takes snapshots meanwhile, from any thread, does not change the result.
using AtlasWatch = std::function<std::shared_ptr<void>(const Atlas&)>;

// Checks the options before it reads anything, and that each view alone fits into planner.max_bytes before it plans
// anything. Writes nothing, to no stream either; tools/pipeline/save_model.h writes the result. Throws InputError, what
// check() throws, with VisibilityBy::gl GlError, and BuildStopped once the callback has returned false.
[[nodiscard]] BuildResult build_model(const std::filesystem::path& scene, const BuildOptions& options,
                                      const BuildCallback& callback = {}, const AtlasWatch& watch = {});

}  // namespace lumatlas
