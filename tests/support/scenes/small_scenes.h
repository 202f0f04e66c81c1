// SPDX-License-Identifier: GPL-3.0-or-later
// A small scene for tests above mesh/: a room of 4 x 4 x 3 with a box in it, cameras inside that look around, and
// photographs whose colours encode where they are, so that a flip or a shift shows.
#pragma once

#include <cstddef>
#include <memory>

#include "atlas/atlas.h"
#include "mesh/camera/camera.h"

namespace lumatlas {

[[nodiscard]] std::shared_ptr<const Surface> room_surface();

// Camera number `number` of an endless walk round the room; 96 x 72 pixels.
[[nodiscard]] Camera room_camera(std::size_t number);

// Smooth, different at every pixel and for every seed.
[[nodiscard]] Photograph pattern_photograph(const Camera& camera, std::size_t seed);

// The first `views` cameras of the walk, all stored, every cell referring to each view that sees it. A layout
// that has not room for all tiles needs a policy.
[[nodiscard]] std::unique_ptr<Atlas> room_atlas(std::size_t views, const ValidityOptions& options,
                                                const TileOptions& layout = kWholeViews, TilePolicy policy = {});
[[nodiscard]] Snapshot room_snapshot(std::size_t views, const ValidityOptions& options,
                                     const TileOptions& layout = kWholeViews, TilePolicy policy = {});

// The same of whole views, each with another gain, so that the exposure of a picture depends on its camera.
[[nodiscard]] Snapshot exposed_room_snapshot(std::size_t views);

}  // namespace lumatlas
