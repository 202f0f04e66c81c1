// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/scene_notes.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <set>
#include <system_error>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/photographs/photograph_names.h"
#include "tools/scene/picture_shape.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// Endings of pictures that cameras make and this program does not read.
constexpr std::array kUnreadEndings{".jxl", ".jp2", ".gif"};

// The folder that the names of the photographs go from; empty if that is the scene's own, where anything may lie.
fs::path photograph_folder(const SceneViews& scene) {
  if (scene.views.empty()) return {};
  const SceneView& view = scene.views.front();
  const std::string image = view.image.generic_string();
  const std::string name = photograph_name(view);
  if (!image.ends_with("/" + name)) return {};
  fs::path folder = image.substr(0, image.size() - name.size() - 1);
  return folder.lexically_normal() == (scene.root / "").lexically_normal().parent_path() ? fs::path() : folder;
}

std::set<std::string> names_of(const std::vector<SceneView>& views) {
  std::set<std::string> names;
  for (const SceneView& view : views) names.insert(photograph_name(view));
  return names;
}

// Returns files of the folder and those below, sorted by name, without hidden ones.
std::vector<std::string> unread_files_in(const fs::path& folder, const std::set<std::string>& named) {
  std::vector<std::string> files;
  for (const char* const ending : kUnreadEndings) {
    for (const fs::path& file : files_ending_in(folder, ending)) {
      std::string name = file.filename().string();
      if (!name.starts_with('.') && !named.contains(name)) files.push_back(std::move(name));
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string one_of_them(const std::string& name) {
  return ", the first of them " + short_reason(name);
}

}  // namespace

std::vector<fs::path> mask_names(const std::string& photograph) {
  const std::string stem = fs::path(photograph).replace_extension().generic_string();
  std::vector<fs::path> names;
  for (const std::string& name : {photograph + ".png", stem + ".png", stem + "_mask.png", stem + ".mask.png",
                                  photograph + ".mask.png", photograph + "_mask.png"}) {
    names.emplace_back(name);
  }
  return names;
}

std::string no_mask_fits(const fs::path& folder, const std::vector<SceneView>& views) {
  const std::vector<std::string> pictures = pictures_in(folder);
  const std::vector<fs::path> names = mask_names(photograph_name(views.front()));
  return folder.string() + ": has a mask of none of the " + std::to_string(views.size()) + " photographs: that of " +
         short_reason(photograph_name(views.front())) + " would be " + short_reason(names[0].string()) + " or " +
         short_reason(names[2].string()) +
         (pictures.empty() ? ", but there is no picture" : ", but there is " + short_reason(pictures.front()));
}

namespace {

// Returns false for a mask that cannot be opened: loading the photograph says why.
bool is_scaled(const SceneView& view) {
  try {
    const ImageSize mask = photograph_size(*view.mask, Orientation::as_stored), size = size_of_file(view);
    return mask.width != size.width && same_shape(mask, size);
  } catch (const InputError&) {
    return false;
  }
}

void note_scaled_masks(SceneViews& scene) {
  const auto count = std::count_if(scene.views.begin(), scene.views.end(),
                                   [](const SceneView& view) { return view.mask && is_scaled(view); });
  if (count == 0) return;
  scene.notes.push_back(std::to_string(count) + " masks have another size than their photographs, and are scaled");
}

}  // namespace

void note_masks(const fs::path& folder, SceneViews& scene) {
  note_scaled_masks(scene);
  const std::vector<std::string> pictures = pictures_in(folder);
  if (pictures.empty()) return;
  const std::size_t masked = masked_views(scene);
  if (masked == 0) {
    scene.notes.push_back(no_mask_fits(folder, scene.views));
    return;
  }
  const auto unmasked =
      std::find_if(scene.views.begin(), scene.views.end(), [](const SceneView& v) { return !v.mask; });
  if (unmasked != scene.views.end()) {
    scene.notes.push_back(std::to_string(masked) + " of " + std::to_string(scene.views.size()) +
                          " photographs have a mask, the others are used whole" + one_of_them(unmasked->name));
  }
  std::set<std::string> fitting;
  for (const SceneView& view : scene.views) {
    for (const fs::path& name : mask_names(photograph_name(view))) fitting.insert(name.generic_string());
    if (view.mask)
      fitting.insert(view.mask->lexically_normal().lexically_relative(folder.lexically_normal()).generic_string());
  }
  std::vector<std::string> unused;
  std::copy_if(pictures.begin(), pictures.end(), std::back_inserter(unused),
               [&](const std::string& picture) { return !fitting.contains(picture); });
  if (unused.empty()) return;
  scene.notes.push_back(std::to_string(unused.size()) + " of " + std::to_string(pictures.size()) + " masks in " +
                        folder.string() + " fit no photograph and are not used" + one_of_them(unused.front()));
}

void note_unposed(std::size_t left_out, SceneViews& scene) {
  const fs::path folder = photograph_folder(scene);
  if (folder.empty()) return;
  const std::set<std::string> named = names_of(scene.views);
  const std::vector<std::string> pictures = pictures_in(folder);
  std::vector<std::string> unposed;
  std::copy_if(pictures.begin(), pictures.end(), std::back_inserter(unposed), [&](const std::string& picture) {
    return !named.contains(picture) && !fs::path(picture).filename().string().starts_with('.');
  });
  if (unposed.size() > left_out) {
    scene.notes.push_back(std::to_string(unposed.size()) + " of " + std::to_string(pictures.size()) +
                          " photographs in " + folder.string() + " have no pose and are not used" +
                          one_of_them(unposed.front()));
  }
  const std::vector<std::string> unread = unread_files_in(folder, named);
  if (unread.empty()) return;
  scene.notes.push_back(std::to_string(unread.size()) + " files in " + folder.string() +
                        " are of a form that is not read" + one_of_them(unread.front()) +
                        ": convert them to JPEG before the poses are made");
}

}  // namespace lumatlas
