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
#include "tools/base/progress.h"
#include "tools/meshing/cut/visibility_cut.h"
#include "tools/meshing/surface_trust.h"
#include "tools/scene/mesh/mesh_frame.h"
#include "tools/scene/scene.h"
#include "tools/scene/scene_points.h"
#include "tools/stereo/scene_stereo.h"

namespace lumatlas {

// The source of a mesh.
enum class MeshSource { points, depth_images, photographs };

[[nodiscard]] std::string name_of(MeshSource source);  // "points", "depth images" or "photographs"

struct SceneMeshOptions {
  // Mesh file to complete (tools/meshing/mesh_completion.h). The file stays as it is. None: the new mesh stands alone.
  std::optional<std::filesystem::path> complete;
  MeshFrame complete_frame;                     // the frame of that file against the poses
  std::optional<MeshSource> from;               // source of the surface; none: see mesh_from_scene()
  std::optional<std::filesystem::path> points;  // PLY file; none: the scene's own points (tools/scene/scene_points.h)
  PictureFolders pictures;                      // folders of the photographs and their masks

  // Options for points and photographs.
  double spacing_px = 4;              // points closer than this are merged; pixels of the nearest view, [0, 1000]
  std::size_t most_points = 200'000;  // spacing_px grows until at most this many points are left, >= 4; 1 GB by default
  // Longest edge of a face, in medians of all faces' longest edges, [1, 1e6]; the mesh leaves larger faces out. None:
  // 20 for points and 30 for photographs, whose points are denser.
  std::optional<double> longest_edge;
  CutOptions cut;

  // Options for depth images.
  std::optional<double> voxel;       // scene units, > 0; none: 1.5 pixels of a depth image at the middle depth
  std::optional<double> depth_unit;  // scene units that a step of a depth image is, > 0; none: as the scene's form says
  std::size_t most_faces = 500'000;  // edges are collapsed until at most this many faces are left, >= 100

  // Options for photographs.
  StereoOptions stereo;
  std::uint32_t block_px = 2;  // side of the squares that give one point each, pixels of the matched size, [1, 64];
                               // larger where the squares of all photographs are far more than most_points
  std::filesystem::path stereo_folder;  // working folder of SceneStereo; mesh_from_scene() makes it
  std::size_t most_photographs = 200;   // largest number of photographs to match, >= 2; else an even sample
  std::optional<HoldOut> hold_out;      // protocol whose held-out photographs are not matched
};

// Throws std::invalid_argument naming the field, its value and the rule.
void check(const SceneMeshOptions& options);

// Facts about the fusion of depth images.
struct DepthFacts {
  std::size_t images = 0;
  std::size_t measured = 0;          // pixels of them all
  double voxel = 0, truncation = 0;  // scene units
  double voxel_px = 0;               // in pixels of a depth image at the middle depth
  double confirmed = 0;              // share of the depths in sight of other depth images that these have too, [0, 1]
  std::size_t removed_pieces = 0, removed_faces = 0;  // small ones that hung in the air
  std::size_t fused_faces = 0;                        // before edges were collapsed
};

// Facts about the completion of the mesh file SceneMeshOptions::complete.
struct CompletionFacts {
  std::filesystem::path file;
  std::size_t added_faces = 0;
  double covered_before = 0, covered = 0;  // shares of the photographs' pixels that see a surface, [0, 1]
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

// Makes a mesh from points by a visibility cut. Points and poses are in the scene's own coordinates. Throws InputError
// where the points make no surface.
[[nodiscard]] SceneMesh mesh_from_points(ScenePoints points, const SceneViews& scene, const SceneMeshOptions& options,
                                         const StageProgress& progress);

// Makes a mesh from the source options.from. Without it, the first of these that there is: options.points, depth
// images, dense points of another program (fused.ply), photographs. The same scene gives the same mesh. `chosen`, if
// given, is called with the source before the work begins; what it throws ends the work. Throws InputError, also where
// the source is too little for a surface.
[[nodiscard]] SceneMesh mesh_from_scene(const std::filesystem::path& scene, const SceneMeshOptions& options,
                                        const StageProgress& progress,
                                        const std::function<void(MeshSource)>& chosen = {});

}  // namespace lumatlas
