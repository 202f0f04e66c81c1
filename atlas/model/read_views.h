// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: makes the views of a model file, of which it has photographs, cameras and tiles, but no depths
// and masks.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "atlas/model/gltf/field_reader.h"
#include "atlas/model/model_file.h"
#include "atlas/tiles/tiles.h"
#include "atlas/views/stored_view.h"
#include "atlas/views/validity.h"
#include "mesh/camera/camera.h"
#include "mesh/mesh.h"

namespace lumatlas {

// A stored view, less its pixels.
struct ViewEntry {
  std::string name;
  Camera camera;
  glm::dvec3 gain{1.0};
  GltfImage image;
  std::optional<GltfImage> lens_mask, trust_mask;
  std::optional<GltfImage> mask, thumbnail;  // what a page shows; their pixels are not read
};

// Returns the size of an image from its header. Throws InputError.
[[nodiscard]] ImageSize size_of(const GltfImage& image);

// Reads the photographs, and makes depths and masks of what they see of the mesh. Of a view only the tiles that are
// resident, with their gutters, are kept in memory. Null for a view that has none. `model` names the file that lists
// the views. Adds the times of the steps to `times`. Throws InputError: if several views cannot be read, for the first,
// whichever thread was faster.
[[nodiscard]] std::vector<std::shared_ptr<const StoredView>> read_views(const std::vector<ViewEntry>& entries,
                                                                        const std::filesystem::path& model,
                                                                        const Mesh& mesh, const TileTable& tiles,
                                                                        const ValidityOptions& options,
                                                                        ReadTimes& times);

}  // namespace lumatlas
