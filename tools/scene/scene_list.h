// SPDX-License-Identifier: GPL-3.0-or-later
// Which photographs a scene's files list, whether or not the photographs themselves are there yet.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "tools/scene/scene.h"

namespace lumatlas {

// A view before anybody has looked at its photograph: how that is turned, its mask and whether it is bad are not known.
struct ListedView {
  SceneView view;
  std::string named_by, sized_by;  // what names the photograph, and what says its size, for messages
};

struct SceneList {
  std::string form;                // as SceneViews::form
  std::vector<std::string> notes;  // as SceneViews::notes
  std::vector<ListedView> views;   // by name, in byte order; at least one
  std::vector<SceneDepth> depths;  // as SceneViews::depths
  std::size_t left_out = 0;        // photographs that the notes say are left out
};

// The list of the scene that read_scene_views() reads. `offset` is subtracted from every camera position. Forms that
// leave the size of photographs open need these; of COLMAP's none is looked at. Throws InputError.
[[nodiscard]] SceneList list_scene_views(const std::filesystem::path& scene, const glm::dvec3& offset,
                                         const PictureFolders& folders);

// The files whose change can change the list: the form's own, and of COLMAP its cameras. Those that are not there are
// left out. Never throws.
[[nodiscard]] std::vector<std::filesystem::path> files_of_list(const std::filesystem::path& scene);

// Finds out how the photograph's pixels become the lens's image. Throws InputError unless the file is there and of the
// lens's size.
[[nodiscard]] Orientation orientation_of(const ListedView& listed);

// The mask of the view in the scene's folder of masks, or that which was asked for; none if there is none.
[[nodiscard]] std::optional<std::filesystem::path> mask_of(const SceneView& view, const std::filesystem::path& folder);
[[nodiscard]] std::filesystem::path mask_folder(const std::filesystem::path& scene, const PictureFolders& folders);

}  // namespace lumatlas
