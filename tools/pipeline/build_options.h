// SPDX-License-Identifier: GPL-3.0-or-later
// The options of a build.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "atlas/tiles/tiles.h"
#include "mesh/cells/cells.h"
#include "planner/planner.h"
#include "tools/budget/bound.h"
#include "tools/pipeline/surface/baked_texture.h"
#include "tools/pipeline/surface/completed_surface.h"
#include "tools/pipeline/view_stream.h"
#include "tools/scene/mesh/mesh_frame.h"
#include "tools/scene/scene.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

// Bytes of photographs to choose tiles from, for each that tiles may take on the GPU.
inline constexpr std::uint64_t kPhotographsPerArray = 4;
// Returns the bytes of photographs to keep for tiles of `tile_bytes`. Compressed tiles count as they would
// uncompressed.
[[nodiscard]] std::uint64_t photograph_bytes_for(std::uint64_t tile_bytes, const TileOptions& tiles);

// The parts that are corrected before a view is stored: see planner/refinement/refiner.h.
enum class RefineMode {
  none,
  exposure,  // gains
  pose,      // poses, gains stay 1
  all,       // gains, poses, lenses, and masks of what the other views contradict; see StreamRefinement
  joint,     // and afterwards all stored views together, until they rest; see refine_jointly()
};

// The method that chooses the views that are stored. All but the first are there to compare it with: they choose before
// anything is stored.
enum class ViewChoice {
  online,   // the planner, view by view
  offline,  // the offline planner, which looks through all cameras first: see planner/offline_planner.h
  uniform,  // views evenly spaced along the stream
  random,   // views by chance
};

// The method that finds the visible surface: rays on the processor or drawing on the GPU. They agree except at
// silhouettes.
enum class VisibilityBy {
  rays,  // mesh/visibility/visibility.h, on the processor
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

// The main memory that photographs and masks of stored views may take while a model is built. See pixel_memory.h.
struct MemoryOptions {
  std::optional<std::uint64_t> bytes;    // none: usual_pixel_memory()
  std::filesystem::path scratch_folder;  // takes the rest; empty: the system's folder for temporary files
};

struct BuildOptions {
  std::optional<std::filesystem::path> mesh;  // none: looked for beside the scene
  // The frame of the mesh file against that of the poses. None: they are the same, and build_model() refuses a mesh
  // that is certainly in another frame (MeshDiagnosis::wrong_frame). A frame that is given is taken as it is.
  std::optional<MeshFrame> mesh_frame;
  PictureFolders pictures;                   // photographs and masks
  std::optional<GeoReference> georeference;  // of the poses' coordinates; none: what the scene says of them
  CellOptions cells;
  FaceOptions faces;  // the mesh's faces that are kept; with pixels, fewer where a bound asks for it: see fewer_faces.h
  CompletionOptions completion;   // the mesh's completion; not with `watch`, for which not all photographs are there
  bool measure_deviation = true;  // measures the deviation of the surface; else the surface counts as exact
  double close_holes = 0;         // holes of the mesh up to this across are closed, scene units, >= 0
  VisibilityBy visibility_by = VisibilityBy::rays;
  // coverage.ideal_distance 0: the median camera-surface distance of the scene; max_loss_db needs ViewChoice::online
  PlannerOptions planner;
  RefineMode refine = RefineMode::joint;  // switches off what planner.refinement has on, never on
  std::uint32_t max_polish_steps = 15;    // for RefineMode::joint, >= 1; lenses and poses may take it further
  bool refine_lenses = true;              // for RefineMode::all and joint: see planner/refinement/lens_estimate.h
  bool refine_shutters = true;            // for RefineMode::joint: see planner/refinement/shutter_estimate.h
  std::optional<std::uint32_t> max_views = 100;  // N, >= 1; none: bounded by planner.max_bytes alone
  TileOptions tiles;                             // max_tiles: 0, for `bound` says it
  // The tiles to use instead of `tiles` in three cases: bound.gpu_bytes() has no room for all photographs whole, or
  // for the largest max_views of them; with `watch` they are not known in advance; bound.texel_loss_db() allows it.
  // None: `tiles` all the same. Both cut views into tiles.
  std::optional<TileOptions> tight_tiles;
  // Bytes need `tiles` that cut views. With bytes of the GPU, and without max_views and planner.max_bytes, the planner
  // holds four times the photographs that fit, to choose tiles from.
  //
  // A loss needs planner.max_loss_db, which is what remains of the allowance for views that are left out. Texels are
  // compressed if there are tight_tiles; then all photographs are downscaled as far as the loss of texels allows. The
  // surface may then move by faces.pixels of the photographs as they are now, if that and the texels cost at most the
  // loss of faces: see fewer_faces.h. It adds nothing to the loss that the other two allow.
  Bound bound;
  MemoryOptions memory;
  // Smallest scale, in (0, 1], that fitting to `bound` may shrink photographs to. Fitting to bytes of the GPU stops
  // before if giving up parts of some photographs is better: see fitted_views.h.
  double least_scale = 0.25;
  // The longest side of the texture that other programs show, [kLeastTexturePx, kMostTexturePx]; none: they show the
  // averaged colours of vertices.
  std::optional<std::uint32_t> texture_px = 2048;
  std::optional<HoldOut> hold_out;  // none: every view is offered
  // The watch on a scene whose folder fills up; empty: the scene is complete. Watching needs ViewChoice::online,
  // StreamOrder::given (photographs are offered as they arrive, those that arrive together by name), no hold_out, which
  // needs all names, and a bound: max_views, planner.max_bytes or bytes of the GPU.
  std::optional<WatchOptions> watch;
  // Build also where most views see next to nothing of the mesh, or it is certainly in another frame.
  bool any_mesh = false;
  StreamOrder order = StreamOrder::given;
  // Where the store cannot hold all photographs, they are all read, and of those that show much the same a sharp one is
  // stored rather than a blurred one. For ViewChoice::online without planner.max_loss_db and watch, and
  // Metric::directions.
  bool sharp_first = true;
  // With another choice than online, planner.max_bytes allows as many views as it holds of the largest one.
  ViewChoice choice = ViewChoice::online;
  std::uint64_t seed = 0;  // for StreamOrder::shuffled and ViewChoice::random
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const BuildOptions& options);

}  // namespace lumatlas
