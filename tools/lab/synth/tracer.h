// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs of synthetic scenes by ray tracing: direct light of the area lights with soft shadows, ambient light with
// occlusion, and one glossy reflection. Radiance 1 is white, unless the exposure says otherwise.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/camera/camera.h"
#include "tools/lab/synth/errors/motion.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas::synth {

// Converts light to the camera's values, before they are cut off at white and rounded to 8 bits.
struct Exposure {
  glm::vec3 gain{1.0F};  // factor of the linear light, per channel, > 0
  // The light is also multiplied by 1 - vignetting r^2 at the middle of a pixel, r being its distance from the
  // principal point over half of the picture's diagonal; [0, 1).
  double vignetting = 0;
  // Noise of the sensor, added to that light in each channel by itself: the standard deviation that it gives a mid grey
  // (sRGB 128), in 8-bit levels, >= 0. Its variance grows with the light (shot noise) from a small part of it (read
  // noise).
  double noise = 0;
  // The motion of the camera while the shutter is open, half of it before the camera's pose and half after.
  Motion motion{};
};

// Solids that stand in the scene for some photographs, lit like everything else, and are not in its mesh. Copies share
// what they hold.
class Visitor {
 private:
  friend class Tracer;
  struct Body;
  explicit Visitor(std::shared_ptr<const Body> body) : body_(std::move(body)) {}
  std::shared_ptr<const Body> body_;
};

// The point that a ray hits.
struct Sighting {
  glm::vec3 point;
  glm::vec3 normal;  // unit, of the flat faces, towards where the ray came from
  const Surface* surface;
  const Material* material;
};

// Safe to call from several threads at once. The scene must outlive the tracer.
class Tracer {
 public:
  explicit Tracer(const Scene& scene);  // throws std::runtime_error if Embree refuses the mesh
  ~Tracer();
  Tracer(Tracer&&) noexcept;
  Tracer& operator=(Tracer&&) noexcept;

  // Each pixel is the mean over its square of the light that falls on it, by `samples` >= 1 stratified paths. The same
  // bytes for any number of threads. Throws std::invalid_argument for a bad camera or no samples.
  [[nodiscard]] Photograph photograph(const Camera& camera, std::uint32_t samples, std::uint64_t seed,
                                      const Exposure& exposure = {}, const Visitor* visitor = nullptr) const;

  // The solids' materials are indices into `materials`.
  [[nodiscard]] Visitor visitor(std::span<const Solid> solids, std::vector<Material> materials) const;
  // White where the visitor is what the middle of a pixel shows, black elsewhere.
  [[nodiscard]] Photograph mask(const Camera& camera, const Visitor& visitor) const;

  // The point of the scene's surface that an image position shows; none where the ray hits nothing.
  [[nodiscard]] std::optional<glm::dvec3> surface_at(const Camera& camera, const glm::dvec2& position) const;
  // The first surface that the ray meets, with what is there; it points into the scene.
  [[nodiscard]] std::optional<Sighting> sighting_at(const Camera& camera, const glm::dvec2& position) const;
  // Returns whether nothing lies between two points, apart from the last 1e-3 of the way.
  [[nodiscard]] bool sees(const glm::dvec3& from, const glm::dvec3& to, const Visitor* visitor = nullptr) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lumatlas::synth
