// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/seen_faces.h"

#include <algorithm>
#include <optional>

#include "mesh/base/requirement.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

std::vector<SeenFaces> seen_faces(std::span<const FaceId> face, std::span<const CellId> cell_of_face) {
  std::vector<SeenFaces> runs;
  std::optional<std::uint32_t> cell;
  for (const FaceId seen : face) {
    const CellId next = seen < cell_of_face.size() ? cell_of_face[seen] : CellId::none;
    if (next != cell) runs.push_back({seen, 0});
    cell = next;
    ++runs.back().pixels;
  }
  runs.shrink_to_fit();
  return runs;
}

std::vector<FaceId> faces_of(std::span<const SeenFaces> runs) {
  std::size_t pixels = 0;
  for (const SeenFaces& run : runs) pixels += run.pixels;
  std::vector<FaceId> faces;
  faces.reserve(pixels);
  for (const SeenFaces& run : runs) faces.insert(faces.end(), run.pixels, run.face);
  return faces;
}

FaceLookup::FaceLookup(std::span<const SeenFaces> runs, std::uint32_t width, std::uint32_t height)
    : runs_(runs), width_(width) {
  constexpr Requirement seen_faces_requires{"seen faces"};
  ends_.reserve(runs.size());
  std::size_t end = 0;
  for (const SeenFaces& run : runs) ends_.push_back(end += run.pixels);
  seen_faces_requires.has_size(end, std::size_t{width} * height, "runs", "the number of the image's pixels");
  std::size_t run = 0;
  for (std::uint32_t row = 0; row < height; ++row) {
    while (ends_[run] <= std::size_t{row} * width) ++run;
    first_run_.push_back(run);
  }
}

FaceId FaceLookup::at(std::size_t pixel) const {
  const std::size_t row = pixel / width_;
  const auto first = ends_.begin() + static_cast<std::ptrdiff_t>(first_run_[row]);
  const auto last =
      row + 1 < first_run_.size() ? ends_.begin() + static_cast<std::ptrdiff_t>(first_run_[row + 1] + 1) : ends_.end();
  return runs_[static_cast<std::size_t>(std::upper_bound(first, last, pixel) - ends_.begin())].face;
}

}  // namespace lumatlas
