// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/cell_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace lumatlas {

namespace {

constexpr CellId kChanged{0xFFFFFFFEU};  // marks a pixel that may show what has changed
constexpr double kAround = 1;            // pixels around a sphere that count as its own, because of rounding

bool is_same(const Camera& a, const Camera& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy &&
         a.cam_from_world_rotation == b.cam_from_world_rotation &&
         a.cam_from_world_translation == b.cam_from_world_translation;
}

// Pixels from `first` to below `end`.
struct PixelRun {
  std::uint32_t first, end;
};

// Returns the pixels along an axis that may show what is between `middle - radius` and `middle + radius` there, at
// depths from `near`, > 0, to `far`.
PixelRun pixels_between(double middle, double radius, double near, double far, double focal, double principal,
                        std::uint32_t count) {
  const double low = middle - radius, high = middle + radius;
  const double first = focal * (low / (low < 0 ? near : far)) + principal - 0.5 - kAround;
  const double last = focal * (high / (high > 0 ? near : far)) + principal - 0.5 + kAround;
  const auto pixel = [&](double at) { return static_cast<std::uint32_t>(std::clamp<double>(at, 0, count)); };
  return {pixel(std::floor(first)), pixel(std::ceil(last) + 1)};
}

// Marks the pixels that may show the sphere.
void mark_pixels(const Camera& camera, const ChangedSphere& sphere, std::vector<std::uint8_t>& wanted) {
  const glm::dvec3 center = camera.cam_from_world_rotation * sphere.center + camera.cam_from_world_translation;
  const double near = center.z - sphere.radius, far = center.z + sphere.radius;
  if (far < 0) return;
  if (!(near > 0)) {  // it may be all around the camera
    std::fill(wanted.begin(), wanted.end(), std::uint8_t{1});
    return;
  }
  const PixelRun x = pixels_between(center.x, sphere.radius, near, far, camera.fx, camera.cx, camera.width);
  const PixelRun y = pixels_between(center.y, sphere.radius, near, far, camera.fy, camera.cy, camera.height);
  for (std::uint32_t row = y.first; row < y.end && x.first < x.end; ++row) {
    const auto begin = wanted.begin() + static_cast<std::ptrdiff_t>(std::size_t{row} * camera.width);
    std::fill(begin + x.first, begin + x.end, std::uint8_t{1});
  }
}

std::vector<CellPixels> counts_of(std::span<const CellId> picture, std::size_t cells) {
  std::vector<std::uint32_t> pixels(cells, 0);
  for (const CellId cell : picture) {
    if (cell != CellId::none) ++pixels[cell];
  }
  std::vector<CellPixels> counts;
  for (CellId cell{0}; cell < cells; ++cell) {
    if (pixels[cell] > 0) counts.push_back({cell, pixels[cell]});
  }
  return counts;
}

}  // namespace

void CellPictures::follow(std::span<const CellId> now, std::span<const ChangedSphere> changed) {
  for (auto& [slot, picture] : pictures_) {
    std::vector<std::uint8_t> marked(picture.cells.size(), 0);
    for (const ChangedSphere& sphere : changed) mark_pixels(picture.camera, sphere, marked);
    for (std::size_t pixel = 0; pixel < marked.size(); ++pixel) {
      CellId& cell = picture.cells[pixel];
      if (marked[pixel] != 0) cell = kChanged;
      if (cell == CellId::none || cell == kChanged) continue;
      const CellId number = cell < now.size() ? now[cell] : CellId::none;
      cell = number == CellId::none ? kChanged : number;
    }
  }
}

std::vector<CellPixels> CellPictures::count(ViewSlot slot, const Camera& camera, const Visibility& visibility,
                                            const Cells& cells) {
  Picture picture{camera, {}};
  std::vector<std::uint8_t> wanted(std::size_t{camera.width} * camera.height, 1);
  const auto known = pictures_.find(slot);
  if (known != pictures_.end() && is_same(known->second.camera, camera)) {
    picture = std::move(known->second);
    for (std::size_t pixel = 0; pixel < wanted.size(); ++pixel) wanted[pixel] = picture.cells[pixel] == kChanged;
  } else {
    picture.cells.resize(wanted.size());
  }
  pictures_.erase(slot);
  VisibilityBuffer buffer;
  visibility.trace_wanted(camera, wanted, buffer);
  for (std::size_t pixel = 0; pixel < wanted.size(); ++pixel) {
    if (wanted[pixel] == 0) continue;
    const FaceId face = buffer.face[pixel];
    picture.cells[pixel] = face == FaceId::none ? CellId::none : cells.cell_of_face.at(face);
  }
  std::vector<CellPixels> counts = counts_of(picture.cells, cells.cells.size());
  pictures_.emplace(slot, std::move(picture));
  return counts;
}

void CellPictures::keep_only(std::span<const ViewSlot> slots) {
  std::erase_if(pictures_, [&](const auto& entry) {
    return !std::binary_search(slots.begin(), slots.end(), ViewSlot(entry.first));
  });
}

}  // namespace lumatlas
