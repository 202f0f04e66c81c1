// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/picture_parts.h"

#include <algorithm>

namespace lumatlas {

namespace {

// One axis of a part.
struct Stretch {
  std::uint32_t drawn, drawn_size, copied, copied_size;
};

std::vector<Stretch> stretches_of(std::uint32_t size, std::uint32_t most) {
  const std::uint32_t count = (size + most - 1) / most;
  const std::uint32_t step = (size + count - 1) / count;
  const std::uint32_t drawn_size = std::min(size, step + 2 * kAroundPart);
  std::vector<Stretch> stretches;
  for (std::uint32_t first = 0; first < size; first += step) {
    const std::uint32_t before = std::min(first, kAroundPart);
    stretches.push_back({std::min(first - before, size - drawn_size), drawn_size, first, std::min(step, size - first)});
  }
  return stretches;
}

}  // namespace

std::vector<PicturePart> parts_of(std::uint32_t width, std::uint32_t height, std::uint32_t most) {
  const std::vector<Stretch> columns = stretches_of(width, most);
  std::vector<PicturePart> parts;
  for (const Stretch& row : stretches_of(height, most)) {
    for (const Stretch& column : columns) {
      parts.push_back({{column.drawn, row.drawn, column.drawn_size, row.drawn_size},
                       {column.copied, row.copied, column.copied_size, row.copied_size}});
    }
  }
  return parts;
}

Camera camera_of_part(const Camera& camera, const PartRect& part) {
  Camera shown = camera;
  shown.width = part.width;
  shown.height = part.height;
  shown.cx -= part.left;
  shown.cy -= part.top;
  return shown;
}

}  // namespace lumatlas
