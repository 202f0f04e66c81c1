// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/colmap/known_poses.h"

#include <cstdint>
#include <map>
#include <string>
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
    throw InputError(place + " has a lens for which COLMAP has no model (" + std::string(name(view.lens.model)) +
                     "): give undistorted photographs with their poses, or leave --poses out");
  }
  if (view.orientation == Orientation::exif) {
    throw InputError(place + " is that of the upright photograph, and COLMAP sees it as it is stored: save the " +
                     "photographs without an EXIF orientation");
  }
}

// Adds the views whose photographs `captured_names` lists by their names in `folder`, but none twice. Returns the list.
SceneList add_poses(const fs::path& scene, const fs::path& folder,
                    const std::map<std::string, std::string>& captured_names,
                    std::map<std::string, WrittenView>& known) {
  PictureFolders pictures;
  pictures.images = folder;
  pictures.skip_bad = true;
  SceneList list = list_scene_views(scene, glm::dvec3(0), pictures);
  for (ListedView& listed : list.views) {
    const SceneView& view = listed.view;
    const auto captured = captured_names.find(photograph_name(view));
    if (captured == captured_names.end() || known.contains(captured->second) || !fits_its_photograph(listed)) continue;
    require_as_colmap_sees_it(scene, view);
    known.emplace(captured->second, WrittenView{captured->second, view.camera, view.lens});
  }
  return list;
}

}  // namespace

KnownPoses read_known_poses(const fs::path& scene, const CapturedPhotographs& captured) {
  std::map<std::string, std::string> own_names, names_before;
  for (const CapturedPhotograph& photograph : captured.photographs) {
    own_names.emplace(photograph.name, photograph.name);
    if (!photograph.converted.empty()) names_before.emplace(photograph.converted, photograph.name);
  }
  std::map<std::string, WrittenView> found;
  const SceneList list = add_poses(scene, captured.folder, own_names, found);
  if (!names_before.empty()) (void)add_poses(scene, captured.source_folder, names_before, found);
  KnownPoses known{list.form, {}};
  for (auto& [name, view] : found) known.views.push_back(std::move(view));
  if (known.views.size() >= 2) return known;
  const CapturedPhotograph& first = captured.photographs.front();
  throw InputError(scene.string() + ": read as " + list.form + ", it has poses of " +
                   std::to_string(known.views.size()) + " of the " + std::to_string(captured.photographs.size()) +
                   " photographs in " + captured.given.string() +
                   ", at least two must have one: their names are compared, such as " + list.views.front().view.name +
                   " and " + (first.converted.empty() ? first.name : first.converted));
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
