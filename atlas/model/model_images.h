// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: the images of a model file, photographs and masks, as they are written.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/images/photograph.h"

namespace lumatlas {

enum class ModelImageKind { photograph, lens_mask, trust_mask };

inline constexpr const char* kImageFolder = "images";  // within a model's folder

// The parts of a file's name that do not depend on its content, within the model's folder: "images/00000" and ".png".
struct ModelFileName {
  std::string stem, ending;
};

struct ModelImage {
  ModelImageKind kind;
  std::uint32_t slot;  // the view's slot in the snapshot
  ModelFileName name;
  ImageCoding coding;  // masks are PNG
};

// Those of all views of a snapshot in their order: of each its photograph, then the masks that it has.
[[nodiscard]] std::vector<ModelImage> images_of(const Snapshot& snapshot, const ImageCoding& photographs);

// The base texture's.
[[nodiscard]] ModelFileName texture_name(const ImageCoding& coding);

// The bytes of a file.
[[nodiscard]] std::vector<std::uint8_t> encoded(const ModelImage& image, const Snapshot& snapshot);

}  // namespace lumatlas
