// SPDX-License-Identifier: GPL-3.0-or-later
// Closed bodies of triangles, and how they are cut more finely without a change of shape.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace lumatlas::synth {

struct Polyhedron {
  std::vector<glm::dvec3> points;
  std::vector<glm::uvec3> faces;  // counter-clockwise, seen from outside
};

[[nodiscard]] Polyhedron icosahedron();  // not of unit size

// The polyhedron with each face cut into `frequency`^2 flat ones; frequency >= 1. Points on shared edges are
// shared.
[[nodiscard]] Polyhedron cut_flat(const Polyhedron& base, std::uint32_t frequency);

}  // namespace lumatlas::synth
