// SPDX-License-Identifier: GPL-3.0-or-later
// A model on disk: a folder with a 3D Tiles tileset, its surface and its images, or one .glb with everything in it,
// from which the renderer draws without the original scene, and the page in a browser. Other programs show the surface
// with its base texture, or, without one, its vertex colours; the extension LUMATLAS_lumigraph (atlas/README.md) adds
// the views, cells and references.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/model/model_form.h"
#include "atlas/views/validity.h"

namespace lumatlas {

// Writes the files of write_form() into `folder`, which must exist. The model is there whole once tileset.json is,
// which comes last. Until then a model that is there already stays as it is, also where the process is killed or a file
// cannot be written; then its files are removed. With photographs as PNG, reading the model back gives the same
// pictures to the bit. Free view slots and views without a resident tile are left out: the others keep their order,
// their slots become consecutive. Vertices are split where cells and fade zones meet, which reading undoes at fade
// zones; faces keep their order. Names become Unicode on one line. The mesh's own colours are left out: what is shown
// of them is in the snapshot's vertex colours. With a texture vertices are there once more for each of its places that
// a corner has, which reading undoes. A cell size above the diagonal of the mesh's box is written as that. Throws
// InputError if a file cannot be written, and what write_form() throws.
void write_model(const std::filesystem::path& folder, const Snapshot& given, const ValidityOptions& validity,
                 const FormOptions& options = {});
// Writes a model whose surface comes in pieces.
void write_model(const std::filesystem::path& folder, const PiecewiseModel& given, const ValidityOptions& validity,
                 const FormOptions& options = {});

// Writes the same model as one .glb, never packed. `notes`, the text of a JSON object or empty, says how the model was
// made: it becomes the asset's "extras". The caller checks whether the stream has failed. Throws InputError for a model
// of 4 GiB or more, the limit of a .glb, and std::invalid_argument for notes that are no JSON object or as
// write_model() does. Holds the whole file in memory, twice.
void write_glb(std::ostream& file, const Snapshot& given, const ValidityOptions& validity,
               const FormOptions& options = {}, const std::string& notes = {});

// The time of each step of reading a model, milliseconds. The last three are sums over the threads.
struct ReadTimes {
  double tables = 0;  // JSON, mesh, cells, references
  double views = 0;   // all of the rest
  double images = 0;
  double depth = 0;
  double masks = 0;
};

struct Model {
  Snapshot snapshot;
  ValidityOptions validity;  // that its masks were made with
  ReadTimes times;
};

// Reads a model folder, its tileset.json, or a .glb, which may have any name. It asks only the size of a base texture,
// because the renderer has the photographs. Depth and validity are not in the file: they are made again from the mesh,
// with the options that it was written with. A view without a resident tile is left out and its photograph not opened.
// Opens nothing outside the folder, not even through a symbolic link. Throws InputError with file, index, value and
// fault. If several views cannot be read, it names the first.
[[nodiscard]] Model read_model(const std::filesystem::path& path);

// The contents of a model file and their sizes, found without reading pixels.
struct ModelFacts {
  std::filesystem::path file;              // the tileset, or the .glb
  std::string json;                        // its JSON
  std::vector<std::string> uris;           // of all other files, relative to the tileset; none of a .glb
  std::shared_ptr<const Surface> surface;  // vertices are split at the borders of cells, not in the texture
  std::size_t cells_seen = 0;
  std::vector<Camera> views;
  ReferenceTable references;
  TileTable tiles;
  std::optional<GeoReference> georeference;
  // Bytes on disk.
  std::uint64_t json_bytes = 0;
  std::uint64_t mesh_bytes = 0;    // positions and faces
  std::uint64_t vertex_bytes = 0;  // colours, the vertices' cells and places in the texture
  std::uint64_t table_bytes = 0;   // cells, their coverage, references, tiles
  std::uint64_t photograph_bytes = 0;
  std::uint64_t mask_bytes = 0;
  std::uint64_t preview_bytes = 0;  // thumbnails, poster, coarse mesh
  std::uint64_t texture_bytes = 0;  // the texture's image; 0: there is none
};

// Checks all but the images, of which it asks the size. Throws InputError as read_model().
[[nodiscard]] ModelFacts read_model_facts(const std::filesystem::path& path);

// The JSON of a folder's tileset or of a .glb, without any check but that its file can be read and nests no deeper than
// 64. Throws InputError.
[[nodiscard]] std::string read_model_json(const std::filesystem::path& path);

}  // namespace lumatlas
