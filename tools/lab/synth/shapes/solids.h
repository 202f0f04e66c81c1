// SPDX-License-Identifier: GPL-3.0-or-later
// The solids that synthetic scenes are built of, and their tessellation into one manifold mesh. z is up.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "mesh/mesh.h"
#include "tools/lab/synth/shapes/surface.h"

namespace lumatlas::synth {

inline constexpr std::int32_t kOpen = -1;  // in place of a material: no surface here

// Sides in the order -x, +x, -y, +y, -z, +z.
struct BlockPart {
  glm::dvec3 min{0.0}, max{1.0};
  std::array<std::int32_t, 6> material{};  // kOpen: a hole in the surface
};

// The union of boxes that touch face to face (never overlap), turned by `yaw` about z and then moved to `origin`.
// There is no surface where two parts touch.
struct Block {
  glm::dvec3 origin{0.0};
  double yaw = 0;  // radians
  std::vector<BlockPart> parts;
  bool hollow = false;  // the parts are air in a solid: a room, seen from inside
};

// Upright, a prism of kCylinderSides sides whose corners lie on the circle.
inline constexpr std::uint32_t kCylinderSides = 48;
struct Cylinder {
  glm::dvec3 base{0.0};  // centre of the bottom
  double radius = 1;
  double height = 1;
  std::int32_t side = 0, bottom = 0, top = 0;  // materials
};

// A geodesic sphere of 20 * kSphereFrequency^2 flat faces, its corners on the sphere.
inline constexpr std::uint32_t kSphereFrequency = 8;
struct Sphere {
  glm::dvec3 center{0.0};
  double radius = 1;
  std::int32_t material = 0;
};

// A convex body with flat sides, turned by `yaw` about z and then moved to `origin`.
struct ConvexSide {
  std::vector<std::uint32_t> corners;  // at least three, not in a line, counter-clockwise seen from outside
  std::int32_t material = 0;           // kOpen: no surface
};
struct Convex {
  glm::dvec3 origin{0.0};
  double yaw = 0;  // radians
  std::vector<glm::dvec3> corners;
  std::vector<ConvexSide> sides;
};

// A roof over the rectangle of `size` (along x and y) round the origin: two slopes that meet in a ridge along x at
// `height`, triangular ends and a bottom.
[[nodiscard]] Convex gable_roof(const glm::dvec2& size, double height, std::int32_t slopes, std::int32_t ends);

// Upright, between two regular polygons round the axis through the origin. A top radius of 0 makes a point of the top.
struct FrustumSize {
  std::uint32_t sides;  // >= 3
  double bottom_radius, top_radius, height;
};
[[nodiscard]] Convex frustum(const FrustumSize& size, std::int32_t side, std::int32_t bottom, std::int32_t top);

using Solid = std::variant<Block, Cylinder, Sphere, Convex>;

// Inside the boxes, the cylinder, the ball, the body; whether the solid is hollow makes no difference.
[[nodiscard]] bool contains(const Solid& solid, const glm::dvec3& point);

struct Tessellation {
  Mesh mesh;  // without colours; manifold, faces oriented towards the air
  std::vector<Surface> surfaces;
  std::vector<std::uint32_t> surface_of_face;  // one per face of the mesh
};

// Faces of the solids with no edge of a flat piece longer than about `max_edge` > 0 along its sides. The geometry does
// not depend on max_edge, only how finely it is cut.
[[nodiscard]] Tessellation tessellate(std::span<const Solid> solids, double max_edge);

// Returns the number of faces that tessellate() makes.
[[nodiscard]] double count_faces(std::span<const Solid> solids, double max_edge);

// The max_edge for about `faces` faces: within a few per cent where the solids are cut into many pieces, more where the
// fewest faces that they can have exceed the target.
[[nodiscard]] double edge_for_faces(std::span<const Solid> solids, double faces);

}  // namespace lumatlas::synth
