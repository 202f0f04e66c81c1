// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs of synthetic scenes by ray tracing: direct light of the area lights with soft shadows, ambient light with
// occlusion, and one glossy reflection. Exposure is fixed: radiance 1 is white.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>

#include "atlas/photograph.h"
#include "mesh/camera.h"
#include "tools/synth.h"

namespace lumatlas::synth {

// Safe to call from several threads at once. The scene must outlive the tracer.
class Tracer {
 public:
  explicit Tracer(const Scene& scene);  // throws std::runtime_error if Embree refuses the mesh
  ~Tracer();
  Tracer(Tracer&&) noexcept;
  Tracer& operator=(Tracer&&) noexcept;

  // Each pixel is the mean over its square of the light that falls on it, by `samples` >= 1 stratified paths. The same
  // bytes for any number of threads. Throws std::invalid_argument for a bad camera or no samples.
  [[nodiscard]] Photograph photograph(const Camera& camera, std::uint32_t samples, std::uint64_t seed) const;

  // Whether nothing lies between two points, apart from the last 1e-3 of the way.
  [[nodiscard]] bool sees(const glm::dvec3& from, const glm::dvec3& to) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// One photograph; for several, keep a Tracer.
[[nodiscard]] Photograph trace_photograph(const Scene& scene, const Camera& camera, std::uint32_t samples,
                                          std::uint64_t seed);

}  // namespace lumatlas::synth
