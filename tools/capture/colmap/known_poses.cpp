// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/colmap/known_poses.h"

#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/capture/colmap/colmap_database.h"
#include "tools/capture/work_folder.h"
#include "tools/scene/scene.h"
#include "tools/scene/scene_list.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// Scales the lens to the photograph's size. Returns false where the pose cannot be used.
bool fits_its_photograph(ListedView& listed) {
  if (!listed.view.bad.empty()) return false;
  try {
    fit_to_photograph(listed);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

// Throws InputError where COLMAP would see the photograph otherwise than the pose is meant.
void require_as_colmap_sees_it(const fs::path& scene, const SceneView& view) {
  const std::string place = scene.string() + ": the pose of " + view.name;
  if (view.panorama) throw InputError(place + " is that of a panorama, for which --poses cannot be used");
  if (static_cast<std::int32_t>(view.lens.model) >= kColmapModelCount) {
    throw InputError(place + " has a lens of which COLMAP has no model (" + std::string(name(view.lens.model)) +
                     "): give undistorted photographs with their poses, or leave --poses out");
  }
  if (view.orientation == Orientation::exif) {
    throw InputError(place + " is that of the upright photograph, and COLMAP sees it as it is stored: save the " +
                     "photographs without an EXIF orientation");
  }
}

}  // namespace

KnownPoses read_known_poses(const fs::path& scene, const CapturedPhotographs& captured) {
  PictureFolders pictures;
  pictures.images = captured.folder;
  pictures.skip_bad = true;
  SceneList list = list_scene_views(scene, glm::dvec3(0), pictures);
  const std::vector<std::string> names = names_of(captured);
  const std::set<std::string> wanted(names.begin(), names.end());
  KnownPoses known{list.form, {}};
  for (ListedView& listed : list.views) {
    const SceneView& view = listed.view;
    if (!wanted.contains(photograph_name(view)) || !fits_its_photograph(listed)) continue;
    require_as_colmap_sees_it(scene, view);
    known.views.push_back({view.name, view.camera, view.lens});
  }
  if (known.views.size() >= 2) return known;
  throw InputError(scene.string() + ": read as " + list.form + ", it has poses of " +
                   std::to_string(known.views.size()) + " of the " + std::to_string(names.size()) + " photographs in " +
                   captured.folder.string() + ", at least two must have one: their names are compared, such as " +
                   list.views.front().view.name + " and " + names.front());
}

void write_known_poses(const KnownPoses& known, const fs::path& database, const fs::path& folder) {
  const std::map<std::string, std::uint32_t> ids = image_ids(database);
  std::vector<WrittenView> written;
  for (WrittenView view : known.views) {
    const auto found = ids.find(view.name);
    if (found == ids.end()) continue;
    view.id = found->second;
    written.push_back(std::move(view));
  }
  if (written.empty()) throw InputError(database.string() + ": has none of the photographs whose poses are known");
  remove_all_of(folder);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(folder.string() + ": cannot be made (" + error.message() + ")");
  write_colmap_model(folder, written, {});
}

}  // namespace lumatlas
