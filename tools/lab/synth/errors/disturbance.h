// SPDX-License-Identifier: GPL-3.0-or-later
// Known errors of a synthetic scene: what its photographs and written poses have that the truth has not. Each kind of
// error depends on the seed, the view and its own option alone, so that kinds can be switched one by one.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "mesh/camera/camera.h"
#include "tools/lab/synth/errors/passer_by.h"
#include "tools/lab/synth/synth.h"
#include "tools/lab/synth/tracer.h"

namespace lumatlas::synth {

struct Disturbance {
  Camera written;              // the true camera with the pose that is written
  bool wrong = false;          // plainly, rather than by pose noise
  double displacement_px = 0;  // the surface's in the picture, root mean square; infinite where part of it is behind
  Exposure exposure;
  double blur_px = 0;  // how far the surface moves in the picture while the shutter is open, root mean square
  std::optional<PasserBy> passer_by;
};

// One per camera. Without disturbances in the options, what is written is what is true.
[[nodiscard]] std::vector<Disturbance> disturb(const Scene& scene, const Tracer& tracer,
                                               std::span<const Camera> cameras, const SynthOptions& options);

// The points of the surface at the middles of a grid of at most 32 x 32 equal parts of the picture.
[[nodiscard]] std::vector<glm::dvec3> points_in_view(const Tracer& tracer, const Camera& camera);

// Root mean square distance, in pixels, between the images of the points in both cameras: 0 without points, infinite if
// one of the points is not in front of both.
[[nodiscard]] double displacement_px(const Camera& a, const Camera& b, std::span<const glm::dvec3> points);

}  // namespace lumatlas::synth
