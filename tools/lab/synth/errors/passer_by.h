// SPDX-License-Identifier: GPL-3.0-or-later
// People who walk through a photograph: they are traced in it and are not in the mesh.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

#include "mesh/camera/camera.h"
#include "tools/lab/synth/synth.h"
#include "tools/lab/synth/tracer.h"

namespace lumatlas::synth {

inline constexpr double kLeastPasserBy = 0.03;  // share of the picture that a passer-by takes up, at least

struct PasserBy {
  Visitor visitor;
  double share;  // share of the picture, >= kLeastPasserBy
};

// A person of boxes on the floor, 1 to 3 m from the camera across the floor, clear of walls and furniture; place,
// height, bearing and clothes depend on the seed. None where no such place is found in view.
[[nodiscard]] std::optional<PasserBy> find_passer_by(const Scene& scene, const Tracer& tracer, const Camera& camera,
                                                     std::uint64_t seed);

// Returns whether a ball of this radius touches no solid: its centre and the ends of its axes are in the air of the
// rooms, and nothing is between them.
[[nodiscard]] bool is_free(const Scene& scene, const Tracer& tracer, const glm::dvec3& center, double radius);

// White pixels' share of a mask.
[[nodiscard]] double white_share(const Photograph& mask);

}  // namespace lumatlas::synth
