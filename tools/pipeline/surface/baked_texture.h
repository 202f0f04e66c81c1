// SPDX-License-Identifier: GPL-3.0-or-later
// The base texture of a model's file, baked from the photographs that it holds (tools/texture/README.md): small, for it
// is what programs show that do not know the extension, before or instead of the photographs.
#pragma once

#include <cstddef>
#include <cstdint>

#include "atlas/base_texture.h"
#include "atlas/snapshot.h"
#include "tools/budget/build_progress.h"

namespace lumatlas {

inline constexpr std::uint32_t kLeastTexturePx = 64, kMostTexturePx = 16384;  // texels along a base texture's side

struct BakedTexture {
  BaseTexture texture;
  std::size_t charts = 0;
  double texels_per_pixel = 0;  // along a side, of the median photograph that sees a place
  double bake_ms = 0;
};

// One page of at most `most_side_px` (see above) texels a side, with at most half as many along a line as the median
// photograph there has pixels, as JPEG. The same bytes for any number of threads.
// Throws std::invalid_argument for another side or a snapshot that does not pass check(), ChartsDoNotFit, Interrupted,
// and BuildStopped.
[[nodiscard]] BakedTexture bake_texture(const Snapshot& snapshot, std::uint32_t most_side_px,
                                        const BuildCallback& callback = {});

}  // namespace lumatlas
