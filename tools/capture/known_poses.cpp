// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/known_poses.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <stdexcept>

#include "mesh/base/errors.h"
#include "tools/capture/work_folder.h"
#include "tools/scene/forms/colmap_writer.h"
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
  if (view.orientation == Orientation::exif) {
    throw InputError(place + " is that of the upright photograph, and COLMAP sees it as it is stored: save the " +
                     "photographs without an EXIF orientation");
  }
}

}  // namespace

KnownPoses write_known_poses(const fs::path& scene, const CapturedPhotographs& captured, const fs::path& folder) {
  PictureFolders pictures;
  pictures.images = captured.folder;
  pictures.skip_bad = true;
  SceneList list = list_scene_views(scene, glm::dvec3(0), pictures);
  const std::vector<std::string> names = names_of(captured);
  const std::set<std::string> wanted(names.begin(), names.end());
  KnownPoses known{list.form, 0, {}};
  std::vector<WrittenView> written;
  std::set<std::string> posed;
  for (ListedView& listed : list.views) {
    const SceneView& view = listed.view;
    if (!wanted.contains(photograph_name(view)) || !fits_its_photograph(listed)) continue;
    require_as_colmap_sees_it(scene, view);
    written.push_back({view.name, view.camera, view.lens});
    posed.insert(view.name);
  }
  known.posed = posed.size();
  std::set_difference(wanted.begin(), wanted.end(), posed.begin(), posed.end(), std::back_inserter(known.missing));
  if (known.posed < 2) {
    throw InputError(scene.string() + ": read as " + list.form + ", it has poses of " + std::to_string(known.posed) +
                     " of the " + std::to_string(names.size()) + " photographs in " + captured.folder.string() +
                     ", at least two must have one: their names are compared, such as " + list.views.front().view.name +
                     " and " + names.front());
  }
  remove_all_of(folder);
  fs::create_directories(folder);
  try {
    write_colmap_model(folder, written, {});
  } catch (const std::invalid_argument& error) {
    throw InputError(scene.string() + ": " + error.what() +
                     ": give undistorted photographs with their poses, or leave --poses out");
  }
  return known;
}

}  // namespace lumatlas
