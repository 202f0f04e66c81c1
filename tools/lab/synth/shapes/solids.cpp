// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/shapes/solids.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <map>
#include <numbers>
#include <unordered_map>
#include <utility>

#include "tools/lab/synth/shapes/polyhedron.h"

namespace lumatlas::synth {
namespace {

using glm::dvec3;

std::uint32_t steps(double length, double max_edge) {
  constexpr double kMost = 65535;  // keeps lattice indices within 20 bits each for up to 16 intervals
  return static_cast<std::uint32_t>(std::clamp(std::ceil(length / max_edge - 1e-9), 1.0, kMost));
}

std::uint32_t add_vertex(Tessellation& out, const dvec3& position) {
  out.mesh.positions.emplace_back(position);
  return static_cast<std::uint32_t>(out.mesh.positions.size() - 1);
}

void add_face(Tessellation& out, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t surface) {
  out.mesh.faces.emplace_back(a, b, c);
  out.surface_of_face.push_back(surface);
}

void add_quad(Tessellation& out, const std::array<std::uint32_t, 4>& v, std::uint32_t surface) {
  add_face(out, v[0], v[1], v[2], surface);
  add_face(out, v[0], v[2], v[3], surface);
}

std::uint32_t add_surface(Tessellation& out, const Surface& surface) {
  out.surfaces.push_back(surface);
  return static_cast<std::uint32_t>(out.surfaces.size() - 1);
}

// ---- Blocks: the boundary of a set of boxes on the grid that their sides span.

// A frame (u, v) on the plane that faces each of the six directions, with cross(u, v) towards it; v is never reversed.
struct SideFrame {
  int u_axis, u_sign, v_axis;
};
constexpr std::array<SideFrame, 6> kSideFrames = {
    {{1, -1, 2}, {1, 1, 2}, {0, 1, 2}, {0, -1, 2}, {0, -1, 1}, {0, 1, 1}}};

dvec3 axis_vector(int axis, double sign) {
  dvec3 v(0.0);
  v[axis] = sign;
  return v;
}

dvec3 turned(double yaw, const dvec3& local) {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return {c * local.x - s * local.y, s * local.x + c * local.y, local.z};
}

class BlockGrid {
 public:
  BlockGrid(const Block& block, double max_edge) : block_(block) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const BlockPart& part : block.parts)
        lines_[axis].insert(lines_[axis].end(), {part.min[axis], part.max[axis]});
      std::sort(lines_[axis].begin(), lines_[axis].end());
      lines_[axis].erase(std::unique(lines_[axis].begin(), lines_[axis].end()), lines_[axis].end());
      first_[axis].push_back(0);
      for (std::size_t i = 0; i + 1 < lines_[axis].size(); ++i) {
        first_[axis].push_back(first_[axis].back() + steps(lines_[axis][i + 1] - lines_[axis][i], max_edge));
      }
    }
  }

  // Calls visit(part, side, cell) for every grid rectangle on the boundary that has a material.
  template <typename Visit>
  void for_each_rectangle(const Visit& visit) const {
    glm::ivec3 cell;
    for (cell.x = 0; cell.x < cells(0); ++cell.x) {
      for (cell.y = 0; cell.y < cells(1); ++cell.y) {
        for (cell.z = 0; cell.z < cells(2); ++cell.z) {
          const std::optional<std::size_t> part = part_at(cell);
          for (int side = 0; part && side < 6; ++side) {
            glm::ivec3 beyond = cell;
            beyond[side / 2] += side % 2 == 0 ? -1 : 1;
            if (!part_at(beyond) && block_.parts[*part].material[side] != kOpen) visit(*part, side, cell);
          }
        }
      }
    }
  }

  [[nodiscard]] double count() const {
    double faces = 0;
    for_each_rectangle([&](std::size_t, int side, const glm::ivec3& cell) {
      const SideFrame& frame = kSideFrames[side];
      faces += 2.0 * interval(frame.u_axis, cell) * interval(frame.v_axis, cell);
    });
    return faces;
  }

  void append(Tessellation& out) const {
    std::map<std::pair<std::size_t, int>, std::uint32_t> surfaces;
    std::unordered_map<std::uint64_t, std::uint32_t> vertices;
    for_each_rectangle([&](std::size_t part, int side, const glm::ivec3& cell) {
      const auto [surface, is_new] = surfaces.try_emplace({part, side}, 0);
      if (is_new) surface->second = add_surface(out, side_surface(block_.parts[part], side));
      append_rectangle(side, cell, surface->second, vertices, out);
    });
  }

 private:
  [[nodiscard]] int cells(int axis) const { return static_cast<int>(lines_[axis].size()) - 1; }
  [[nodiscard]] std::uint32_t interval(int axis, const glm::ivec3& cell) const {
    return first_[axis][cell[axis] + 1] - first_[axis][cell[axis]];
  }
  [[nodiscard]] int facing(int side) const { return block_.hollow ? side ^ 1 : side; }

  [[nodiscard]] std::optional<std::size_t> part_at(const glm::ivec3& cell) const {
    dvec3 middle;
    for (int axis = 0; axis < 3; ++axis) {
      if (cell[axis] < 0 || cell[axis] >= cells(axis)) return std::nullopt;
      middle[axis] = 0.5 * (lines_[axis][cell[axis]] + lines_[axis][cell[axis] + 1]);
    }
    for (std::size_t i = 0; i < block_.parts.size(); ++i) {
      const BlockPart& part = block_.parts[i];
      if (glm::all(glm::greaterThan(middle, part.min)) && glm::all(glm::lessThan(middle, part.max))) return i;
    }
    return std::nullopt;
  }

  [[nodiscard]] Surface side_surface(const BlockPart& part, int side) const {
    const SideFrame& frame = kSideFrames[facing(side)];
    dvec3 corner;
    corner[side / 2] = side % 2 == 0 ? part.min[side / 2] : part.max[side / 2];
    corner[frame.u_axis] = frame.u_sign > 0 ? part.min[frame.u_axis] : part.max[frame.u_axis];
    corner[frame.v_axis] = part.min[frame.v_axis];
    Surface surface;
    surface.origin = block_.origin + turned(block_.yaw, corner);
    surface.u = turned(block_.yaw, axis_vector(frame.u_axis, frame.u_sign));
    surface.v = turned(block_.yaw, axis_vector(frame.v_axis, 1));
    surface.size = {part.max[frame.u_axis] - part.min[frame.u_axis], part.max[frame.v_axis] - part.min[frame.v_axis]};
    surface.material = static_cast<std::uint32_t>(part.material[side]);
    return surface;
  }

  [[nodiscard]] double coordinate(int axis, std::uint32_t index) const {
    const auto after = std::upper_bound(first_[axis].begin(), first_[axis].end() - 1, index);
    const auto cell = static_cast<std::size_t>(after - first_[axis].begin()) - 1;
    if (index == first_[axis][cell]) return lines_[axis][cell];
    if (cell + 1 == lines_[axis].size()) return lines_[axis].back();
    const double share =
        static_cast<double>(index - first_[axis][cell]) / (first_[axis][cell + 1] - first_[axis][cell]);
    return lines_[axis][cell] + share * (lines_[axis][cell + 1] - lines_[axis][cell]);
  }

  std::uint32_t vertex(const glm::uvec3& lattice, std::unordered_map<std::uint64_t, std::uint32_t>& vertices,
                       Tessellation& out) const {
    const std::uint64_t key = (std::uint64_t{lattice.x} << 42U) | (std::uint64_t{lattice.y} << 21U) | lattice.z;
    const auto [entry, is_new] = vertices.try_emplace(key, 0);
    if (is_new) {
      const dvec3 local(coordinate(0, lattice.x), coordinate(1, lattice.y), coordinate(2, lattice.z));
      entry->second = add_vertex(out, block_.origin + turned(block_.yaw, local));
    }
    return entry->second;
  }

  void append_rectangle(int side, const glm::ivec3& cell, std::uint32_t surface,
                        std::unordered_map<std::uint64_t, std::uint32_t>& vertices, Tessellation& out) const {
    const SideFrame& frame = kSideFrames[facing(side)];
    const std::uint32_t u0 = first_[frame.u_axis][cell[frame.u_axis]];
    const std::uint32_t v0 = first_[frame.v_axis][cell[frame.v_axis]];
    glm::uvec3 lattice(0);
    lattice[side / 2] = first_[side / 2][cell[side / 2] + side % 2];
    const auto corner = [&](std::uint32_t u, std::uint32_t v) {
      lattice[frame.u_axis] = u;
      lattice[frame.v_axis] = v;
      return vertex(lattice, vertices, out);
    };
    for (std::uint32_t v = v0; v < v0 + interval(frame.v_axis, cell); ++v) {
      for (std::uint32_t u = u0; u < u0 + interval(frame.u_axis, cell); ++u) {
        const std::uint32_t from = frame.u_sign > 0 ? u : u + 1;
        const std::uint32_t to = frame.u_sign > 0 ? u + 1 : u;
        add_quad(out, {corner(from, v), corner(to, v), corner(to, v + 1), corner(from, v + 1)}, surface);
      }
    }
  }

  const Block& block_;
  std::array<std::vector<double>, 3> lines_;         // coordinates of the grid's planes, per axis
  std::array<std::vector<std::uint32_t>, 3> first_;  // lattice index of each of those planes
};

// ---- Cylinders: rows of quads round the side, rings round each cap's centre.

struct CylinderSteps {
  std::uint32_t around, up, inwards;
};

CylinderSteps cylinder_steps(const Cylinder& cylinder, double max_edge) {
  const double side = 2 * cylinder.radius * std::sin(std::numbers::pi / kCylinderSides);
  return {kCylinderSides * steps(side, max_edge), steps(cylinder.height, max_edge), steps(cylinder.radius, max_edge)};
}

double count(const Cylinder& cylinder, double max_edge) {
  const CylinderSteps n = cylinder_steps(cylinder, max_edge);
  const double cap = n.around * (2.0 * n.inwards - 1);
  const double caps = (cylinder.top != kOpen ? cap : 0) + (cylinder.bottom != kOpen ? cap : 0);
  return caps + (cylinder.side != kOpen ? 2.0 * n.around * n.up : 0);
}

using Ring = std::vector<std::uint32_t>;

// Points of the regular polygon at `scale` of its size.
Ring add_ring(const Cylinder& cylinder, double scale, double height, std::uint32_t around, Tessellation& out) {
  const std::uint32_t per_side = around / kCylinderSides;
  Ring ring;
  for (std::uint32_t i = 0; i < around; ++i) {
    const std::uint32_t side = i / per_side;
    const double from = 2 * std::numbers::pi * side / kCylinderSides;
    const double to = 2 * std::numbers::pi * (side + 1) / kCylinderSides;
    const double share = static_cast<double>(i % per_side) / per_side;
    const dvec3 corner =
        (1 - share) * dvec3(std::cos(from), std::sin(from), 0) + share * dvec3(std::cos(to), std::sin(to), 0);
    ring.push_back(add_vertex(out, cylinder.base + scale * cylinder.radius * corner + dvec3(0, 0, height)));
  }
  return ring;
}

// Faces between two rings, oriented so that with `outer` below `inner` they face away from the axis.
void join_rings(const Ring& outer, const Ring& inner, bool reversed, std::uint32_t surface, Tessellation& out) {
  for (std::size_t i = 0; i < outer.size(); ++i) {
    const std::size_t next = (i + 1) % outer.size();
    if (reversed) {
      add_quad(out, {outer[next], outer[i], inner[i], inner[next]}, surface);
    } else {
      add_quad(out, {outer[i], outer[next], inner[next], inner[i]}, surface);
    }
  }
}

void append_cap(const Cylinder& cylinder, bool top, const Ring& rim, const CylinderSteps& n, Tessellation& out) {
  const dvec3 center = cylinder.base + dvec3(0, 0, top ? cylinder.height : 0);
  const double sign = top ? 1 : -1;
  Surface surface;
  surface.u = {sign, 0, 0};
  surface.v = {0, 1, 0};
  surface.origin = center - cylinder.radius * dvec3(sign, 1, 0);
  surface.size = glm::dvec2(2 * cylinder.radius);
  surface.material = static_cast<std::uint32_t>(top ? cylinder.top : cylinder.bottom);
  const std::uint32_t id = add_surface(out, surface);
  Ring outer = rim;
  for (std::uint32_t ring = n.inwards - 1; ring >= 1; --ring) {
    Ring inner = add_ring(cylinder, static_cast<double>(ring) / n.inwards, top ? cylinder.height : 0, n.around, out);
    join_rings(outer, inner, !top, id, out);
    outer = std::move(inner);
  }
  const std::uint32_t middle = add_vertex(out, center);
  for (std::size_t i = 0; i < outer.size(); ++i) {
    const std::size_t next = (i + 1) % outer.size();
    add_face(out, outer[top ? i : next], outer[top ? next : i], middle, id);
  }
}

void append(const Cylinder& cylinder, double max_edge, Tessellation& out) {
  const CylinderSteps n = cylinder_steps(cylinder, max_edge);
  const bool has_side = cylinder.side != kOpen;
  Ring ring;
  if (has_side || cylinder.bottom != kOpen) ring = add_ring(cylinder, 1, 0, n.around, out);
  if (cylinder.bottom != kOpen) append_cap(cylinder, false, ring, n, out);
  if (has_side) {
    Surface surface;
    surface.shape = Shape::cylinder;
    surface.origin = cylinder.base;
    surface.radius = static_cast<float>(cylinder.radius);
    surface.size = {2 * std::numbers::pi * cylinder.radius, cylinder.height};
    surface.material = static_cast<std::uint32_t>(cylinder.side);
    const std::uint32_t id = add_surface(out, surface);
    for (std::uint32_t row = 1; row <= n.up; ++row) {
      Ring above = add_ring(cylinder, 1, cylinder.height * row / n.up, n.around, out);
      join_rings(ring, above, false, id, out);
      ring = std::move(above);
    }
  }
  if (cylinder.top != kOpen) {
    if (!has_side) ring = add_ring(cylinder, 1, cylinder.height, n.around, out);
    append_cap(cylinder, true, ring, n, out);
  }
}

// ---- Spheres: an icosahedron, cut and pushed out to the sphere, then cut flat.

Polyhedron unit_sphere() {
  const Polyhedron base = icosahedron();
  Polyhedron sphere = cut_flat(base, kSphereFrequency);
  for (dvec3& point : sphere.points) point = glm::normalize(point);
  return sphere;
}

std::uint32_t sphere_steps(const Sphere& sphere, double max_edge) {
  constexpr double kEdge = 1.2;  // about the icosahedron's edge, once pushed out to the unit sphere's surface
  return steps(sphere.radius * kEdge / kSphereFrequency, max_edge);
}

void append(const Sphere& sphere, double max_edge, Tessellation& out) {
  Surface surface;
  surface.shape = Shape::sphere;
  surface.origin = sphere.center;
  surface.radius = static_cast<float>(sphere.radius);
  surface.size = {2 * std::numbers::pi * sphere.radius, std::numbers::pi * sphere.radius};
  surface.material = static_cast<std::uint32_t>(sphere.material);
  const std::uint32_t id = add_surface(out, surface);
  const Polyhedron base = unit_sphere();
  const Polyhedron cut = cut_flat(base, sphere_steps(sphere, max_edge));
  const auto first = static_cast<std::uint32_t>(out.mesh.positions.size());
  for (const dvec3& point : cut.points) add_vertex(out, sphere.center + sphere.radius * point);
  for (const glm::uvec3& f : cut.faces) add_face(out, first + f.x, first + f.y, first + f.z, id);
}

double count(const Sphere& sphere, double max_edge) {
  const double n = kSphereFrequency * sphere_steps(sphere, max_edge);
  return 20 * n * n;
}

// ---- Convex bodies: each side a fan of triangles, all cut alike, so that edges meet.

constexpr std::uint32_t kNone = ~0U;

std::uint32_t convex_steps(const Convex& body, double max_edge) {
  double longest = 0;
  for (const ConvexSide& side : body.sides) {
    for (std::size_t i = 0; i < side.corners.size(); ++i) {
      const dvec3& next = body.corners[side.corners[(i + 1) % side.corners.size()]];
      longest = std::max(longest, glm::distance(body.corners[side.corners[i]], next));
    }
  }
  return steps(longest, max_edge);
}

double count(const Convex& body, double max_edge) {
  const double n = convex_steps(body, max_edge);
  double triangles = 0;
  for (const ConvexSide& side : body.sides) {
    if (side.material != kOpen) triangles += static_cast<double>(side.corners.size()) - 2;
  }
  return triangles * n * n;
}

// The axes of the smallest rectangle round a side, in the world, with t upwards or, on a level side, along y.
Surface side_surface(const Convex& body, const ConvexSide& side) {
  const auto corner = [&](std::size_t i) { return body.origin + turned(body.yaw, body.corners[side.corners[i]]); };
  const dvec3 out = glm::normalize(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
  const bool level = std::abs(out.z) > 1 - 1e-9;
  const dvec3 u = level ? turned(body.yaw, dvec3(out.z, 0, 0)) : glm::normalize(glm::cross(dvec3(0, 0, 1), out));
  const dvec3 v = glm::cross(out, u);
  glm::dvec2 low(std::numeric_limits<double>::infinity());
  glm::dvec2 high(-std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < side.corners.size(); ++i) {
    const glm::dvec2 st(glm::dot(corner(i), u), glm::dot(corner(i), v));
    low = glm::min(low, st);
    high = glm::max(high, st);
  }
  Surface surface;
  surface.origin = low.x * u + low.y * v + glm::dot(corner(0), out) * out;
  surface.u = u;
  surface.v = v;
  surface.size = high - low;
  surface.material = static_cast<std::uint32_t>(side.material);
  return surface;
}

void append(const Convex& body, double max_edge, Tessellation& out) {
  Polyhedron base;
  std::vector<std::uint32_t> surface_of_face;
  std::vector<std::uint32_t> point_of_corner(body.corners.size(), kNone);  // those of open sides alone are left out
  const auto point = [&](std::uint32_t corner) {
    if (point_of_corner[corner] == kNone) {
      point_of_corner[corner] = static_cast<std::uint32_t>(base.points.size());
      base.points.push_back(body.origin + turned(body.yaw, body.corners[corner]));
    }
    return point_of_corner[corner];
  };
  for (const ConvexSide& side : body.sides) {
    if (side.material == kOpen) continue;
    const std::uint32_t surface = add_surface(out, side_surface(body, side));
    for (std::size_t i = 2; i < side.corners.size(); ++i) {
      const std::uint32_t a = point(side.corners[0]);
      const std::uint32_t b = point(side.corners[i - 1]);
      base.faces.emplace_back(a, b, point(side.corners[i]));
      surface_of_face.push_back(surface);
    }
  }
  const std::uint32_t n = convex_steps(body, max_edge);
  const Polyhedron cut = cut_flat(base, n);
  const auto first = static_cast<std::uint32_t>(out.mesh.positions.size());
  for (const dvec3& position : cut.points) add_vertex(out, position);
  for (std::size_t i = 0; i < cut.faces.size(); ++i) {
    const glm::uvec3& f = cut.faces[i];
    add_face(out, first + f.x, first + f.y, first + f.z, surface_of_face[i / (std::size_t{n} * n)]);
  }
}

double count(const Block& block, double max_edge) {
  return BlockGrid(block, max_edge).count();
}
void append(const Block& block, double max_edge, Tessellation& out) {
  BlockGrid(block, max_edge).append(out);
}

bool inside(const Block& block, const dvec3& point) {
  const dvec3 local = turned(-block.yaw, point - block.origin);
  return std::any_of(block.parts.begin(), block.parts.end(), [&](const BlockPart& part) {
    return glm::all(glm::greaterThanEqual(local, part.min)) && glm::all(glm::lessThanEqual(local, part.max));
  });
}

bool inside(const Cylinder& cylinder, const dvec3& point) {
  const dvec3 local = point - cylinder.base;
  return std::hypot(local.x, local.y) <= cylinder.radius && local.z >= 0 && local.z <= cylinder.height;
}

bool inside(const Sphere& sphere, const dvec3& point) {
  return glm::length(point - sphere.center) <= sphere.radius;
}

bool inside(const Convex& body, const dvec3& point) {
  const dvec3 local = turned(-body.yaw, point - body.origin);
  return std::all_of(body.sides.begin(), body.sides.end(), [&](const ConvexSide& side) {
    const dvec3& a = body.corners[side.corners[0]];
    const dvec3 out = glm::cross(body.corners[side.corners[1]] - a, body.corners[side.corners[2]] - a);
    return glm::dot(out, local - a) <= 0;
  });
}

}  // namespace

Convex gable_roof(const glm::dvec2& size, double height, std::int32_t slopes, std::int32_t ends) {
  const double x = 0.5 * size.x;
  const double y = 0.5 * size.y;
  Convex roof;
  roof.corners = {{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}, {-x, 0, height}, {x, 0, height}};
  roof.sides = {
      {{0, 1, 5, 4}, slopes}, {{2, 3, 4, 5}, slopes}, {{1, 2, 5}, ends}, {{3, 0, 4}, ends}, {{3, 2, 1, 0}, ends}};
  return roof;
}

Convex frustum(const FrustumSize& size, std::int32_t side, std::int32_t bottom, std::int32_t top) {
  Convex body;
  const auto add_ring = [&](double radius, double height) {
    for (std::uint32_t i = 0; i < size.sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / size.sides;
      body.corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
    }
  };
  const bool pointed = size.top_radius == 0;
  const std::uint32_t n = size.sides;
  add_ring(size.bottom_radius, 0);
  if (pointed) body.corners.emplace_back(0, 0, size.height);
  if (!pointed) add_ring(size.top_radius, size.height);
  ConvexSide below{{}, bottom};
  ConvexSide above{{}, top};
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    body.sides.push_back(pointed ? ConvexSide{{i, next, n}, side} : ConvexSide{{i, next, n + next, n + i}, side});
    below.corners.push_back(n - 1 - i);
    above.corners.push_back(n + i);
  }
  body.sides.push_back(below);
  if (!pointed) body.sides.push_back(above);
  return body;
}

bool contains(const Solid& solid, const glm::dvec3& point) {
  return std::visit([&](const auto& s) { return inside(s, point); }, solid);
}

Tessellation tessellate(std::span<const Solid> solids, double max_edge) {
  Tessellation out;
  for (const Solid& solid : solids) {
    std::visit([&](const auto& s) { append(s, max_edge, out); }, solid);
  }
  return out;
}

double count_faces(std::span<const Solid> solids, double max_edge) {
  double faces = 0;
  for (const Solid& solid : solids) faces += std::visit([&](const auto& s) { return count(s, max_edge); }, solid);
  return faces;
}

double edge_for_faces(std::span<const Solid> solids, double faces) {
  double fine = 1e-4;
  double coarse = 1e4;
  for (int round = 0; round < 60; ++round) {
    const double middle = std::sqrt(fine * coarse);
    (count_faces(solids, middle) > faces ? fine : coarse) = middle;
  }
  return coarse;
}

}  // namespace lumatlas::synth
