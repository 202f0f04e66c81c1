// SPDX-License-Identifier: GPL-3.0-or-later
// Which views may have seen a point, where nobody has noted it down.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "mesh/camera.h"

namespace lumatlas {

inline constexpr std::size_t kMostEstimatedViews = 12;  // of one point

// For each point the views, ascending, in whose picture it lies with nothing before it: the picture is cut into squares
// so large that some four points fall on each, and a point counts as seen unless another one in its square or beside it
// is nearer by a tenth. With `normals` (none, or one a point; (0, 0, 0) says nothing) it must also face the view. Of
// more than kMostEstimatedViews of a point, so many are taken evenly over all. Points in the frame of the cameras.
// `progress` is called after each view, from any thread; what it throws ends the work.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> estimated_views(std::span<const glm::dvec3> points,
                                                                      std::span<const glm::vec3> normals,
                                                                      std::span<const Camera> views,
                                                                      const std::function<void()>& progress);

}  // namespace lumatlas
