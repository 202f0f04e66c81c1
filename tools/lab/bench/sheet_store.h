// SPDX-License-Identifier: GPL-3.0-or-later
// Generated stores for benchmarks: a hilly sheet over the unit square, seen from above in photographs of noise.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "atlas/atlas.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// Returns a sheet of at least that many vertices, in square cells, with hills of `height`.
[[nodiscard]] std::shared_ptr<const Surface> hilly_sheet(std::uint32_t vertices, double height = 0.01);

// Looks at the sheet from above (x, y), so that a photograph is `across` of the sheet wide.
[[nodiscard]] Camera camera_above(double x, double y, double across, std::uint32_t width, std::uint32_t height);

[[nodiscard]] Photograph noise(std::uint32_t width, std::uint32_t height, std::uint32_t seed);

// The layout of sheet_store().
inline constexpr TileOptions kSheetLayout{64, 2, 0};

// Puts views of noise into a store. Every cell refers to the first `references` of those that see it.
[[nodiscard]] std::unique_ptr<Atlas> sheet_store(const std::shared_ptr<const Surface>& surface,
                                                 const Visibility& visibility, std::span<const Camera> cameras,
                                                 std::size_t references = ~std::size_t{0});

}  // namespace lumatlas
