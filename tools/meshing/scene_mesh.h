// SPDX-License-Identifier: GPL-3.0-or-later
// From a scene that has no mesh to one: its points, the views that saw them, the surface, and how far to trust it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mesh/mesh.h"
#include "tools/meshing/surface_trust.h"
#include "tools/meshing/visibility_cut.h"
#include "tools/scene/scene.h"
#include "tools/scene/scene_points.h"
#include "tools/stereo/scene_stereo.h"

namespace lumatlas {

// What a mesh is made of.
enum class MeshSource { points, depth_images, photographs };

[[nodiscard]] std::string name_of(MeshSource source);  // "points", "depth images" or "photographs"

struct SceneMeshOptions {
  // A mesh file that is completed by what is made: see tools/meshing/mesh_completion.h. It is not written to.
  std::optional<std::filesystem::path> complete;
  std::optional<MeshSource> from;               // none: the best that the scene has, see mesh_from_scene()
  std::optional<std::filesystem::path> points;  // a PLY file; none: what the scene has, see scene_points.h
  PictureFolders pictures;                      // photographs, whose sizes are looked at
  // Points closer together are one, pixels of the nearest view; [0, 1000]. Widened until most_points are left.
  double spacing_px = 4;
  std::size_t most_points = 200'000;  // >= 4; time and memory grow with it, 1 GB at the default
  // Of a face, in median longest edges of all; larger faces are left out; [1, 1e6]. None: 20, and 30 of photographs,
  // whose points lie so dense where they lie at all that most of what they leave open is flat.
  std::optional<double> longest_edge;
  CutOptions cut;
  // Of scenes with depth images, which are fused unless `points` are given:
  std::optional<double> voxel;       // scene units, > 0; none: 1.5 pixels of a depth image at the middle depth
  std::optional<double> depth_unit;  // scene units that a step of a depth image is, > 0; none: as the scene's form says
  std::size_t most_faces = 500'000;  // edges are collapsed down to so many, if that can be; >= 100
  // Of photographs:
  StereoOptions stereo;
  std::uint32_t block_px = 2;           // a point for each square of so many pixels as they are compared, [1, 64];
                                        // more where that makes far more points than most_points
  std::filesystem::path stereo_folder;  // where their planes are kept, see SceneStereo; made if need be
  std::size_t most_photographs = 200;   // of more, so many are matched, evenly by name; >= 2
  std::optional<HoldOut> hold_out;      // those that are held out to be scored give no depths
};

// Throws std::invalid_argument naming the field, its value and the rule.
void check(const SceneMeshOptions& options);

// How depth images were fused.
struct DepthFacts {
  std::size_t images = 0;
  std::size_t measured = 0;          // pixels of them all
  double voxel = 0, truncation = 0;  // scene units
  double voxel_px = 0;               // in pixels of a depth image at the middle depth
  double confirmed = 0;              // share of the depths in sight of other depth images that these have too, [0, 1]
  std::size_t removed_pieces = 0, removed_faces = 0;  // small ones that hung in the air
  std::size_t fused_faces = 0;                        // before edges were collapsed
};

// What was added to a mesh that was given.
struct CompletionFacts {
  std::filesystem::path file;  // of the mesh that was given
  std::size_t added_faces = 0;
  double covered_before = 0, covered = 0;  // shares of the photographs' pixels that see a surface
};

struct SceneMesh {
  MeshSource source = MeshSource::points;
  TriangleSoup surface;  // in the scene's coordinates, a colour a vertex where the points have colours
  std::filesystem::path points_file;
  std::size_t points = 0;       // in the file, finite
  std::size_t points_used = 0;  // seen by a view, and told apart
  double spacing_px = 0;        // at which they were
  std::size_t views = 0;
  std::size_t matched = 0;                    // photographs that were matched with each other
  std::optional<DepthFacts> depth;            // in the place of points
  std::optional<CompletionFacts> completion;  // `surface` is then the given mesh with what was added to it
  bool views_estimated = false;               // the file does not say who saw its points
  SurfaceTrust trust;
  std::vector<std::string> warnings;  // reasons not to trust it, in sentences
};

// Warns where the surface leaves photographs empty; empty: it covers them. `names`: those of the views that `trust` is
// of. `lacking`: what there is too little of, "points" for example.
[[nodiscard]] std::string coverage_warning(const SurfaceTrust& trust, const std::vector<std::string>& names,
                                           const std::string& lacking);

// Called when a stage of the work begins, with what it is and its number of steps; returns what is called with the
// steps done since the last call, from any thread. What that throws ends the work.
using StageProgress = std::function<std::function<void(std::size_t)>(const std::string& stage, std::size_t steps)>;

// `points` with their views, in the scene's own coordinates.
[[nodiscard]] SceneMesh mesh_from_points(ScenePoints points, const SceneViews& scene, const SceneMeshOptions& options,
                                         const StageProgress& progress);

// Of what options.from says. Without it: of the points that are given, else of depth images if the scene has them, of
// dense points that another program has left in it (fused.ply), else of its photographs. The same mesh for the same
// scene. `chosen`, if there is one, is called with what the mesh is made of before any work is done, and what it throws
// is thrown on. Throws InputError, also where there is too little to make a surface of.
[[nodiscard]] SceneMesh mesh_from_scene(const std::filesystem::path& scene, const SceneMeshOptions& options,
                                        const StageProgress& progress,
                                        const std::function<void(MeshSource)>& chosen = {});

}  // namespace lumatlas
