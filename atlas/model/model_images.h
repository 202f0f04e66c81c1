// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: the images of a model file, photographs and masks, as they are written.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/images/files/grey_png.h"
#include "atlas/images/photograph.h"

namespace lumatlas {

enum class ModelImageKind {
  photograph,
  lens_mask,
  trust_mask,
  mask,       // validity and rims, in one grey channel: see grey_of_mask()
  thumbnail,  // the photograph, at most 128 pixels a side
  poster,     // a larger one of the photograph where a visitor begins, 640
};

inline constexpr const char* kImageFolder = "images";  // within a model's folder

// The parts of a file's name that do not depend on its content, within the model's folder: "images/00000" and ".png".
struct ModelFileName {
  std::string stem, ending;
};

struct ModelImage {
  ModelImageKind kind;
  ViewSlot slot;  // the view's slot in the snapshot
  ModelFileName name;
  ImageCoding coding;                  // masks are PNG, small pictures JPEG
  PngEffort effort = PngEffort::most;  // for a mask
};

// Returns the images of all views of a snapshot in their order: of each view its photograph, then its other images;
// last the poster of the view in slot `first`. `packed`: without lens and trust masks, which the mask contains.
[[nodiscard]] std::vector<ModelImage> images_of(const Snapshot& snapshot, const ImageCoding& photographs,
                                                ViewSlot first, bool packed);

// A pixel of a mask: twice its validity in 7 bits, rounded up, so that no valid pixel becomes invalid, and one more at
// a rim.
[[nodiscard]] constexpr std::uint8_t grey_of_mask(std::uint8_t validity, bool at_rim) {
  const int half = validity == 255 ? 127 : (validity + 1) / 2;
  return static_cast<std::uint8_t>(2 * half + (at_rim ? 1 : 0));
}

// Returns the name of an image of a view without its ending: "images/00007".
[[nodiscard]] std::string numbered_image(std::size_t view);

// The base texture's.
[[nodiscard]] ModelFileName texture_name(const ImageCoding& coding);

// The bytes of a file.
[[nodiscard]] std::vector<std::uint8_t> encoded(const ModelImage& image, const Snapshot& snapshot);

}  // namespace lumatlas
