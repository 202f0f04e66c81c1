// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/surface_trust_shares.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace lumatlas {

namespace {

constexpr std::uint32_t kGlancePixels = 64;  // longer side of the images in which pixels are counted

struct Counts {
  std::array<std::size_t, 3> within{};
  std::size_t measured = 0;
  std::size_t pixels = 0;
};

void count_pixels(const Snapshot& snapshot, const SurfaceDeviation& deviation, const Camera& camera,
                  const Visibility& visibility, Counts& counts) {
  constexpr std::array<double, 3> kBounds{1, 2, 4};  // pixels
  const VisibilityBuffer visible = visibility.trace(camera.shrunk_to(kGlancePixels));
  const Surface& surface = *snapshot.surface;
  for (std::size_t pixel = 0; pixel < visible.face.size(); ++pixel) {
    const std::uint32_t face = visible.face[pixel];
    if (face == FaceId::none || face >= surface.near_faces()) continue;
    const CellId cell = surface.cells.cell_of_face[face];
    const auto off = static_cast<double>(deviation.of_cell[cell]);
    const double shift = shift_px(off, camera.fx, static_cast<double>(visible.depth[pixel]));
    for (std::size_t i = 0; i < kBounds.size(); ++i) counts.within.at(i) += shift <= kBounds.at(i);
    counts.measured += deviation.measured[cell];
    ++counts.pixels;
  }
}

}  // namespace

TrustShares trust_shares(const Snapshot& snapshot, const SurfaceDeviation& deviation, const Visibility& visibility) {
  Counts counts;
  for (const auto& view : snapshot.views) {
    if (view) count_pixels(snapshot, deviation, view->camera, visibility, counts);
  }
  const auto all = static_cast<double>(std::max<std::size_t>(counts.pixels, 1));
  const auto share = [&](std::size_t count) { return static_cast<double>(count) / all; };
  return {share(counts.within[0]), share(counts.within[1]), share(counts.within[2]), share(counts.measured)};
}

}  // namespace lumatlas
