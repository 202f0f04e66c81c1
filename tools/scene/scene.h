// SPDX-License-Identifier: GPL-3.0-or-later
// A scene as the program is given it: posed photographs on disk and a mesh beside them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/camera/camera.h"
#include "mesh/camera/lens_correction.h"
#include "mesh/camera/shutter_motion.h"
#include "mesh/mesh.h"
#include "tools/scene/geo_reference.h"
#include "tools/scene/lenses/camera_model.h"
#include "tools/scene/lenses/panorama_view.h"

namespace lumatlas {

// One registered photograph. Poses are relative to Scene::offset.
struct SceneView {
  std::string name;                                  // the file's name from its folder on, with '/' between folders
  std::filesystem::path image;                       // the file
  CameraModel lens;                                  // the model's lens, for the photograph's size
  Orientation orientation = Orientation::as_stored;  // how the file's pixels become the lens's image
  Camera camera;  // the pinhole view that the photograph is undistorted to; lens size = its size
  std::optional<std::filesystem::path> mask = std::nullopt;  // a picture, black where pixels are not to be used
  LensCorrection correction =
      {};  // the error of a lens whose photographs are undistorted by it alone; 0 unless one was found
  // The motion of the camera while its shutter read the photograph, for points at the depth 1; 0 unless it was found.
  ShutterMotion motion = {};
  std::string bad = {};    // why its photograph cannot be used; empty: it can. See PictureFolders::skip_bad
  bool black_rim = false;  // a rim of it that is black was not photographed, see tools/scene/lenses/black_rim.h
  // The file is a panorama, of which this is a view; the name is then the panorama's with the view's behind a '/'.
  std::optional<PanoramaFace> panorama = std::nullopt;
  bool held_out = false;  // the scene's own list names it among those to score
};

// The name of the view's file from its folder on; that of views of panoramas is the panorama's.
[[nodiscard]] std::string photograph_name(const SceneView& view);
// The size that the file must have, turned as the view says: the lens's, or that of its panorama.
[[nodiscard]] ImageSize size_of_file(const SceneView& view);

// A depth image of the scene, see PosedDepth.
struct SceneDepth {
  std::filesystem::path file;
  double unit = 0;  // scene units that a stored 1 is
  CameraModel lens;
  Camera camera;  // the pinhole view that it is undistorted to, of the lens's size; its pose relative to the offset
  std::optional<std::filesystem::path> confidence = {};  // a picture of the same size, 0 where the depth is left out
};

// The views of a scene without its mesh, for `--views SCENE`.
struct SceneViews {
  std::filesystem::path root;
  std::vector<SceneView> views;         // sorted by name, in byte order
  std::vector<SceneDepth> depths = {};  // none have been opened
  std::string form = {};                // such as "COLMAP", see tools/scene/forms/capture_forms.h
  std::vector<std::string> notes = {};  // sentences: what was assumed where the form leaves it open, what was left out
  std::optional<GeoReference> georeference = {};  // of the coordinates before the offset is subtracted
};

// The folders of a scene's pictures, if not the usual ones, and how to treat bad pictures.
struct PictureFolders {
  std::optional<std::filesystem::path> images;  // none: SCENE/images
  std::optional<std::filesystem::path> masks;   // none: SCENE/masks, if there is such a folder
  // Views whose photograph or mask is missing, damaged or of another size keep their rank, so that the same others are
  // held out, and are marked as SceneView::bad, rather than refused. Every photograph is then decoded once to find out.
  bool skip_bad = false;
};

// Takes those of bad views away.
void leave_out_bad(const SceneViews& scene, std::vector<std::size_t>& ranks);

// The number of views that have a mask, and of those that the scene's own list holds out.
[[nodiscard]] std::size_t masked_views(const SceneViews& scene);
[[nodiscard]] std::size_t held_out_views(const SceneViews& scene);

// Reads the capture in the folder `scene`, by the first of its forms (tools/scene/forms/capture_forms.h): COLMAP's
// workspace before others, with sparse/, the largest model in a folder of sparse/, or the model's files in the folder
// itself, binary or text, and images/ beside it. Poses and cameras only; photographs are opened for their sizes.
// `offset` is subtracted from every camera position in double precision.
//
// A photograph that is not where the form says is looked for by its name: see find_photographs.h. It is taken as it is
// stored, as COLMAP takes it, even if an EXIF orientation says otherwise; only where that does not fit its camera's
// size but the upright one does, it is turned. If a photograph has another size but the same shape, the lens is scaled,
// and a note says so. The mask of NAME.jpg is NAME.jpg.png, as COLMAP has it, or another of mask_names()
// (tools/scene/scene_notes.h); a photograph need not have one.
//
// Throws InputError: file, index, value, what to do, also where folders.masks has no mask of any photograph, and with
// skip_bad where all are bad.
[[nodiscard]] SceneViews read_scene_views(const std::filesystem::path& scene, const glm::dvec3& offset,
                                          const PictureFolders& folders = {});

// The first file in `scene` of the names that COLMAP, OpenMVS and others give to meshes; none if there is none.
[[nodiscard]] std::optional<std::filesystem::path> mesh_beside(const std::filesystem::path& scene);

// The mesh file to use: `given` if it is given, else mesh_beside(scene). Throws InputError naming all the places that
// were looked at.
[[nodiscard]] std::filesystem::path find_mesh(const std::filesystem::path& scene,
                                              const std::optional<std::filesystem::path>& given);

// The triangles of a PLY, OBJ, STL or glTF file (.glb, .gltf), by its ending in any case, in the file's coordinates;
// tools/scene/mesh/mesh_frame.h takes them to those of the poses. Throws InputError.
[[nodiscard]] TriangleSoup read_scene_mesh(const std::filesystem::path& file);

// Returns the photograph as the view's pinhole camera would have taken it, undistorted by lens and correction
// (bilinear). These pixels are marked invalid: the border that the lens did not see, pixels whose mask is exactly 0 or
// whose alpha in the file is less than half, and a black rim. A view without any of these is returned unchanged, to the
// byte. Throws InputError if the file or the mask cannot be read or has another size than the view's camera.
[[nodiscard]] Photograph load_photograph(const SceneView& view);

// The two ways to hold photographs out (DESIGN: validation protocols).
struct HoldOut {
  std::size_t hold = 8;   // >= 2
  std::size_t block = 1;  // >= 1; 1: every hold-th view is left out and scored
};
// Throws std::invalid_argument naming the field and the rule.
void check(const HoldOut& protocol);

// Ranks (by name) of the views to learn from and of the ones to score. For block = 1: rank % hold == 0 is held out and
// scored. For larger blocks: (rank / block) % hold == 0 is held out, and of those rank % block in {block/4, block/2,
// 3*block/4} is scored.
struct Split {
  std::vector<std::size_t> input;
  std::vector<std::size_t> scored;
};
[[nodiscard]] Split split(std::size_t view_count, const HoldOut& protocol);

// Splits the ranks of a scene's views by the protocol. Without one, the views with SceneView::held_out are scored, and
// the others are to learn from. Bad views are in neither.
[[nodiscard]] Split split(const SceneViews& scene, const std::optional<HoldOut>& protocol);

// Splits as split() does. Throws InputError if no view is left to score.
[[nodiscard]] Split split_to_score(const SceneViews& scene, const std::optional<HoldOut>& protocol);

}  // namespace lumatlas
