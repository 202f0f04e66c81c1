// SPDX-License-Identifier: GPL-3.0-or-later
// Paths that need no key frames: they follow the places from which a scene's own views were taken. They may lead
// through walls and past surfaces without photographs.
//
// `stored` are the cameras of a model's views, at least one (std::invalid_argument); `frames` >= 1; `depth` > 0 is how
// far away from them the surface is typically, scene units; the field of view is that of Vantage.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "mesh/mesh.h"
#include "tools/picture/paths/camera_path.h"

namespace lumatlas {

// Once around the point that the cameras look at, at their median distance from the axis and their median height,
// looking at it; the last frame is one step before the first.
[[nodiscard]] std::vector<Vantage> orbit(std::span<const Camera> stored, double depth, std::size_t frames,
                                         double fov_deg);

// The same at these turns of it, 1 being once around.
[[nodiscard]] std::vector<Vantage> orbit_at(std::span<const Camera> stored, double depth, std::span<const double> turns,
                                            double fov_deg);

// Through the cameras in their order, each a key frame; at a pace at which moving by `depth` takes as long as turning
// by a radian.
[[nodiscard]] std::vector<Vantage> walk(std::span<const Camera> stored, double depth, std::size_t frames,
                                        double fov_deg);

// A square of 2^order cells a side in the order of Hilbert's curve: each cell once, and each the next one's neighbour.
inline constexpr std::uint32_t kMostHilbertOrder = 8;
[[nodiscard]] std::vector<glm::ivec2> hilbert_cells(std::uint32_t order);

// Along a Hilbert curve, with rounded corners, over the ground that the mesh stands on, less the outermost 1 % of its
// area on each side; at the cameras' median height and pitch, looking ahead (paper Fig. 7). order: [1, 8]
// (std::invalid_argument).
[[nodiscard]] std::vector<Vantage> hilbert_flight(const Mesh& mesh, std::span<const Camera> stored, std::uint32_t order,
                                                  std::size_t frames, double fov_deg);

}  // namespace lumatlas
