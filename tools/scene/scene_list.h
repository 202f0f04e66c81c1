// SPDX-License-Identifier: GPL-3.0-or-later
// Lists the photographs that a scene's files name, whether or not the photographs themselves are there yet.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "tools/scene/scene.h"

namespace lumatlas {

// Listed view; its photograph's orientation, mask and validity are still unknown.
struct ListedView {
  SceneView view;
  std::string named_by, sized_by;  // the file that names the photograph, and the one that has its size, for messages
  double scale = 1;                // the lens's scale, width by width
};

struct SceneList {
  std::string form;                // see SceneViews::form
  std::vector<std::string> notes;  // see SceneViews::notes
  std::vector<ListedView> views;   // sorted by name, in byte order; at least one
  std::vector<SceneDepth> depths;  // see SceneViews::depths
  std::size_t left_out = 0;        // photographs that the notes say are left out
  std::optional<GeoReference> georeference = {};
};

// The list of the scene that read_scene_views() reads. `offset` is subtracted from every camera position. Forms that
// leave the size of photographs open need these; of COLMAP's none is looked at. Throws InputError.
[[nodiscard]] SceneList list_scene_views(const std::filesystem::path& scene, const glm::dvec3& offset,
                                         const PictureFolders& folders);

// The files whose change can change the list: the form's own, and of COLMAP its cameras. Those that are not there are
// left out. Never throws.
[[nodiscard]] std::vector<std::filesystem::path> files_of_list(const std::filesystem::path& scene);

// Finds out how the photograph's pixels become the lens's image, and scales the lens and the camera where the
// photograph has another size but the same shape, within a pixel. Throws InputError unless the file is there and of
// such a size.
void fit_to_photograph(ListedView& listed);

// Returns a sentence on the views whose lenses fit_to_photograph() has scaled; empty if there are none.
[[nodiscard]] std::string scaled_lenses_note(const std::vector<ListedView>& views);

// The mask of the view in the scene's folder of masks, or that which was asked for; none if there is none.
[[nodiscard]] std::optional<std::filesystem::path> mask_of(const SceneView& view, const std::filesystem::path& folder);
[[nodiscard]] std::filesystem::path mask_folder(const std::filesystem::path& scene, const PictureFolders& folders);

}  // namespace lumatlas
