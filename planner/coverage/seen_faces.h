// SPDX-License-Identifier: GPL-3.0-or-later
// The faces that the pixels of a view show, as runs, which take less memory than a face for each pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/base/id.h"

namespace lumatlas {

// A run of neighbouring pixels, row by row, that show the same cell, and a face of it; or FaceId::none.
struct SeenFaces {
  FaceId face;
  std::uint32_t pixels;
};

// Returns the runs of a view. `face`: the face of each pixel, as in VisibilityBuffer.
[[nodiscard]] std::vector<SeenFaces> seen_faces(std::span<const FaceId> face, std::span<const CellId> cell_of_face);

// Returns for each pixel a face of the cell that it shows.
[[nodiscard]] std::vector<FaceId> faces_of(std::span<const SeenFaces> runs);

// Finds the face of single pixels. The runs must outlive it.
class FaceLookup {
 public:
  // Throws std::invalid_argument unless the runs have as many pixels as an image of this size.
  FaceLookup(std::span<const SeenFaces> runs, std::uint32_t width, std::uint32_t height);

  // Returns the face of a pixel of the image, by binary search in its row. `pixel`: row * width + column.
  [[nodiscard]] FaceId at(std::size_t pixel) const;

 private:
  std::span<const SeenFaces> runs_;
  std::vector<std::size_t> ends_;       // one per run: the pixel after its last one
  std::vector<std::size_t> first_run_;  // one per row: the run of its first pixel
  std::uint32_t width_;
};

}  // namespace lumatlas
