// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: the parts of a model's JSON, which its files share: a tileset.json with the glTF files that it
// names, or one .glb. atlas/README.md describes the properties.
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "atlas/model/gltf/gltf_builder.h"
#include "atlas/model/model_images.h"
#include "atlas/model/surface/coarse_surface.h"
#include "atlas/model/surface/written_mesh.h"
#include "atlas/snapshot.h"

namespace lumatlas {

// Returns the view slot where a visitor begins: the photograph that most cells refer to, which gives the widest view,
// of those that were held level. `shown`: which view slots count, one for each; at least one does.
[[nodiscard]] ViewSlot first_view_slot(const Snapshot& snapshot, const std::vector<std::uint8_t>& shown);

// The properties of the whole model, without its images, views and poster. `before_far`: depth_before_far() of its
// surface. `first_view`: the view's number.
[[nodiscard]] nlohmann::json model_properties(const Snapshot& snapshot, float before_far,
                                              const ValidityOptions& validity, std::uint32_t first_view);

// The properties of a view, without its images.
[[nodiscard]] nlohmann::json view_properties(const StoredView& view, const glm::dvec3& gain, float before_far);

// The views' properties with the numbers of their images. `images` are those of images_of(), in the file's order.
[[nodiscard]] nlohmann::json views_with_images(const Snapshot& snapshot, float before_far,
                                               const std::vector<ModelImage>& images);

// The part of a surface's file that is about views, which it names by their numbers.
struct ViewTables {
  std::vector<std::uint32_t> references;  // the views of the snapshot's references
  std::vector<std::uint8_t> resident;     // for each tile of all views, 1 or 0; empty with whole views
};
[[nodiscard]] ViewTables view_tables(const Snapshot& snapshot);

struct SurfaceForm {
  int texture = -1;     // number of the base texture's image; -1: there is none
  bool packed = false;  // leaves out what only describes the surface
  bool apart = false;   // colours and tables in buffers of their own
};

// Adds the surface's meshes, and the scene that shows it, and returns the properties of the surface.
nlohmann::json add_surface(GltfBuilder& gltf, const Snapshot& snapshot, const WrittenSurface& written,
                           const ViewTables& tables, const SurfaceForm& form);

// Adds a mesh of vertex colours, and returns its number.
int add_coarse_surface(GltfBuilder& gltf, const CoarseSurface& coarse, std::optional<double> packed);

// Returns the cell size as a file has it: no more than the diagonal of the box of the near mesh.
[[nodiscard]] double written_cell_size(const Surface& surface);

// Adds the numbers as an accessor, and returns its number.
int add_whole_numbers(GltfBuilder& gltf, const std::vector<std::uint32_t>& numbers);

// Adds the scene, whose root shows mesh 0, turned so.
void add_scene(nlohmann::json& document, const glm::dmat3& file_from_scene);

// Adds the scene, whose root is turned so. A node below it shows mesh 0, whose positions are less `origin`.
void add_moved_scene(nlohmann::json& document, const glm::dmat3& file_from_scene, const glm::dvec3& origin);

// Lists the extension with these properties in a document.
void set_lumigraph(nlohmann::json& document, nlohmann::json properties);

// The boxes around a surface.
struct TileVolume {
  Bounds in_scene;  // in the model's frame
  Bounds in_tile;   // as 3D Tiles have it, z upwards
};

// A file that a tileset names.
struct TileContent {
  std::string uri;
  std::uint64_t bytes = 0;
  double geometric_error = 0;  // of 3D Tiles, scene units
  TileVolume volume;           // of a chunk
};

// Returns where the mesh lies whose positions are less `origin`.
[[nodiscard]] TileVolume tile_volume(const Mesh& mesh, const glm::dvec3& origin, const glm::dmat3& file_from_scene);

// A tile of a tileset: a chunk, or a coarse surface that stands in for its children until they are there.
struct ModelTile {
  TileContent content;  // an empty URI: the tile has none
  std::vector<ModelTile> children;
};

// The tileset with that root, which has content or children. `offset`: that of the surface.
[[nodiscard]] nlohmann::json tileset_json(const Snapshot& snapshot, const glm::dvec3& offset, const ModelTile& root,
                                          nlohmann::json properties);

}  // namespace lumatlas
