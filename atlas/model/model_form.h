// SPDX-License-Identifier: GPL-3.0-or-later
// The files of a model, wherever they go: a folder (model_file.h), a page's site, a server. It is a 3D Tiles tileset,
// which atlas/README.md describes.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "atlas/base_texture.h"
#include "atlas/fade_zones.h"
#include "atlas/images/photograph.h"
#include "atlas/model/piecewise_model.h"
#include "atlas/snapshot.h"
#include "atlas/views/validity.h"
#include "mesh/cancel_check.h"

namespace lumatlas {

inline constexpr const char* kTilesetName = "tileset.json";

enum class FormPart { surface, coarse, photograph, mask, thumbnail, poster, texture, views };

struct FormFile {
  std::string stem, ending;  // of its name: "images/00000" and ".png"; what it holds comes between them
  std::string type;          // media type
  FormPart part = FormPart::surface;
  std::span<const std::uint8_t> bytes;
};

// Takes a file, and returns its name, relative to the tileset. Several threads call it at once.
using PutFormFile = std::function<std::string(const FormFile& file)>;

struct FormOptions {
  ImageCoding photographs{};
  const BaseTexture* texture = nullptr;  // of the near faces
  const CellShares* shares = nullptr;    // of all faces
  // In few bytes: the surface is compressed (EXT_meshopt_compression), with positions on a grid finer than photographs
  // resolve, and what a page does not use is left out: lens and trust masks, the cells' coverage, and which vertices
  // are copies.
  bool packed = false;
  // Largest number of faces in a chunk, at least 1. The writer splits a larger surface into chunks; a single cell with
  // more faces is a chunk of its own. A model in one file has one chunk.
  std::size_t chunk_faces = 100'000;
  // Faces of a coarse surface, which readers show until they have the whole one, or the chunks that it stands for; 0:
  // none is written. A surface, or the chunks of a tile, that has at most twice as many faces needs none.
  std::size_t coarse_faces = 60'000;
  // Largest number of views that the tileset lists itself. More are listed in a file of their own, so that the tileset
  // of a city stays small, and a page shows the coarse surface before it knows all views.
  std::size_t listed_views = 200;
};

// Passes all files of the model to `put` but the tileset, whose text it returns. `cancel_check` is called once for each
// view and for the surface, also from several threads. Throws std::invalid_argument unless snapshot, options and
// texture pass check(), InputError for a model that has more than 2^24 cells, or an offset or a camera too far from the
// scene.
[[nodiscard]] std::string write_form(const Snapshot& snapshot, const ValidityOptions& validity,
                                     const FormOptions& options, const PutFormFile& put,
                                     const CancelCheck& cancel_check = {});
// Does the same with a model whose surface comes in pieces, and holds one of them at a time. The pieces say which
// chunks, textures and shares there are, instead of the options.
[[nodiscard]] std::string write_form(const PiecewiseModel& given, const ValidityOptions& validity,
                                     const FormOptions& options, const PutFormFile& put,
                                     const CancelCheck& cancel_check = {});

}  // namespace lumatlas
