// SPDX-License-Identifier: GPL-3.0-or-later
// A model on disk: a folder with a glTF 2.0 file, its buffer and its images, from which the renderer draws without the
// original scene. Any glTF viewer shows the mesh with its vertex colours; the extension LUMATLAS_lumigraph
// (docs/model-format.md) adds the views, cells and references.
#pragma once

#include <filesystem>

#include "atlas/atlas.h"
#include "atlas/validity.h"

namespace lumatlas {

inline constexpr const char* kModelFileName = "scene.gltf";

// Writes scene.gltf, scene.bin and images/ into `folder`, which must exist. Photographs are written as PNG, so that
// reading the model back gives the same pictures to the bit. Free slots are left out: the views keep their order, their
// slots become consecutive. Names become Unicode on one line. The mesh's own colours are left out: what is shown of
// them is in the snapshot's vertex colours. Throws InputError if a file cannot be written.
void write_model(const std::filesystem::path& folder, const Snapshot& snapshot, const ValidityOptions& validity);

struct Model {
  Snapshot snapshot;
  ValidityOptions validity;  // that its masks were made with
};

// Reads a model folder, or its .gltf file. Depth and validity are not in the file: they are made again from the mesh,
// with the options that it was written with. Opens nothing outside of the folder. Throws InputError: file, index,
// value, what is wrong with it; of several views that cannot be read, the first.
[[nodiscard]] Model read_model(const std::filesystem::path& path);

}  // namespace lumatlas
