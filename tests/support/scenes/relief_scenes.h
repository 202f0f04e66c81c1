// SPDX-License-Identifier: GPL-3.0-or-later
// A wall with a smooth relief and a smooth random texture, and photographs of it by ray casting: every colour in them
// is a function of the surface point, so the true pose and exposure of each are known.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"
#include "planner/refinement/median_colors.h"

namespace lumatlas {

// world = scale * rotation * (point on the relief) + translation.
struct Placement {
  double scale = 1;
  glm::dmat3 rotation{1.0};
  glm::dvec3 translation{0.0};

  [[nodiscard]] glm::dvec3 world(const glm::dvec3& relief) const { return scale * (rotation * relief) + translation; }
  [[nodiscard]] glm::dvec3 relief(const glm::dvec3& world) const {
    return glm::transpose(rotation) * (world - translation) / scale;
  }
};

// Linear light that a camera at `center` sees at a point of the relief; both on the relief, not in the world.
using Shading = std::function<glm::dvec3(const glm::dvec3& point, const glm::dvec3& center)>;

// Within [0.04, 0.24] in every channel, so that two stops more are not clipped; waves 0.3 to 2.5 long.
[[nodiscard]] glm::dvec3 relief_color(const glm::dvec3& point);
[[nodiscard]] Shading plain_shading();

// 8 x 6 scene units around the z axis at depths from 3.6 to 4.4.
[[nodiscard]] std::shared_ptr<const Surface> relief_surface(const Placement& placement = {});

// At `center`, looking at `target`, both on the relief; 240 x 180 pixels, a wide 48 pixels per scene unit at depth 4.
[[nodiscard]] Camera relief_camera(const glm::dvec3& center, const glm::dvec3& target, const Placement& placement = {});
// Four units before the wall's middle, `degrees` to the side of it.
[[nodiscard]] Camera camera_on_arc(double degrees);

// The relief, what is visible of it, and photographs of it.
struct Relief {
  explicit Relief(const Placement& where = {});
  // `exposure`: linear light of the photograph over the surface's. Black beside the wall.
  [[nodiscard]] Photograph photograph(const Camera& camera, const glm::dvec3& exposure = glm::dvec3(1.0),
                                      const Shading& shading = plain_shading()) const;
  // Points that the camera sees, evenly over its picture, none near its border.
  [[nodiscard]] std::vector<glm::dvec3> points(const Camera& camera, std::uint32_t columns, std::uint32_t rows) const;

  Placement placement;
  std::shared_ptr<const Surface> surface;
  std::unique_ptr<Visibility> visibility;
};

// Views of a relief, all stored, every cell referring to all of them.
struct Gallery {
  explicit Gallery(std::uint32_t capacity);
  ViewSlot add(const Camera& camera, const Photograph& photograph, const glm::dvec3& gain = glm::dvec3(1.0),
               std::vector<std::uint8_t> trust = {});

  Relief relief;
  Atlas atlas;
  std::vector<std::optional<ComparedView>> views;
};

// Root of the mean squared distance between where the two cameras see the points, pixels.
[[nodiscard]] double pose_error_px(const Camera& a, const Camera& b, const std::vector<glm::dvec3>& points);
// Turned and moved at random (by `seed`), so that pose_error_px() is `px`.
[[nodiscard]] Camera disturbed(const Camera& camera, double px, std::uint32_t seed,
                               const std::vector<glm::dvec3>& points);

}  // namespace lumatlas
