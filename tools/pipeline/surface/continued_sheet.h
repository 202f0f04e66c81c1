// SPDX-License-Identifier: GPL-3.0-or-later
// Makes faces of what one photograph shows where a surface is lacking, by continuing the depths around.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"
#include "tools/pipeline/surface/far_background.h"

namespace lumatlas {

// What a photograph's pixels see, row by row.
struct Sight {
  std::vector<double> inverse_depth;  // 1 / scene units, of the surface or its extension; 0 where neither is
  std::vector<std::uint8_t> lacking;  // 1 where a valid pixel sees neither these nor the far sphere
  std::vector<std::uint8_t> far;      // 1 where a pixel sees the far sphere
  std::size_t lacking_count = 0;

  // Returns whether the photograph lacks enough to offer faces: 0.2 % of its pixels.
  [[nodiscard]] bool lacks_much() const;
};

// `far`, `extension`: null if there is none.
[[nodiscard]] Sight sight_of(const SmallPhotograph& photograph, const Visibility& surface, const Visibility* far,
                             const Visibility* extension);

// What all photographs see of the surface and the far sphere. Refers to the photographs.
class Sights {
 public:
  // Throws Interrupted soon after a signal.
  Sights(const std::vector<SmallPhotograph>& photographs, const Visibility& surface, const Visibility* far);

  [[nodiscard]] const Sight& of(std::size_t photograph) const { return sights_[photograph]; }
  // Returns the photographs that lack much, those that lack most first.
  [[nodiscard]] std::vector<std::size_t> order() const;
  // Returns whether more photographs see something behind a point than lack a surface there.
  [[nodiscard]] bool contradict(const glm::dvec3& point) const;

 private:
  const std::vector<SmallPhotograph>& photographs_;
  std::vector<Sight> sights_;
};

// Faces that one photograph offers, grouped by squares of its picture.
struct Sheet {
  Mesh mesh;  // without colours
  std::vector<std::uint32_t> square_of_face;
  std::size_t squares = 0;  // some may have no face
};

// Returns a grid with a vertex in the middle of each pixel, and those faces of it that touch a lacking pixel and whose
// vertices `sights` do not contradict. Beside the picture it goes on by half a pixel. Where it overlaps the surface
// that it continues, it lies just behind it; past a nearer object, and before the far sphere, it goes on by a pixel.
[[nodiscard]] Sheet continued_sheet(const SmallPhotograph& photograph, const Sight& sight, const Sights& sights);

}  // namespace lumatlas
