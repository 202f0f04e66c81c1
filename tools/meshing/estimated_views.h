// SPDX-License-Identifier: GPL-3.0-or-later
// Estimates which views have seen a point, for points that come without that list.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "mesh/camera/camera.h"

namespace lumatlas {

inline constexpr std::size_t kMostEstimatedViews = 12;  // views of one point

// Returns for each point the views, ascending, whose picture shows it with nothing before it. The picture is cut into
// squares on each of which some four points fall, and a point counts as seen unless another one in its square or beside
// it is nearer by a tenth. With `normals` (none, or one a point; (0, 0, 0) says nothing) it must also face the view. If
// there are more than kMostEstimatedViews, that many are taken evenly. Points are in the frame of the cameras.
// `progress` is called after each view, from any thread; an exception from it ends the work.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> estimated_views(std::span<const glm::dvec3> points,
                                                                      std::span<const glm::vec3> normals,
                                                                      std::span<const Camera> views,
                                                                      const std::function<void()>& progress);

}  // namespace lumatlas
