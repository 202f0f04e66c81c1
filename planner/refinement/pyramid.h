// SPDX-License-Identifier: GPL-3.0-or-later
// A photograph at half, quarter, ... resolution, for coarse-to-fine alignment.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "atlas/images/photograph.h"
#include "atlas/images/stored_photograph.h"

namespace lumatlas {

// Linear colour and its derivatives by image position, per pixel of the full resolution.
struct ColorSample {
  glm::dvec3 color{0.0};
  glm::dvec3 d_x{0.0}, d_y{0.0};
};

// Level 0 is the photograph itself, which must outlive the pyramid; each further level averages 2x2 pixels of the one
// before, in linear light.
//
// Pixels outside of the lens's image (Photograph::valid is 0), which are black, have no part in a mean. A pixel of a
// further level is valid if one of the four is. An invalid one beside valid ones has their mean colour, so that
// interpolation near them meets no black.
//
// Copies share what the levels hold.
class Pyramid {
 public:
  // Makes as many levels as keep the longer side at `coarsest_px` or more, >= 1. Throws std::invalid_argument if that
  // is 0, or if the photograph has no pixel, not three values for each, or a `valid` that is neither empty nor one for
  // each.
  explicit Pyramid(const PhotographSpan& photograph, std::uint32_t coarsest_px = 80);

  [[nodiscard]] std::uint32_t levels() const { return static_cast<std::uint32_t>(levels_.size()); }
  [[nodiscard]] const PhotographSpan& level(std::uint32_t index) const { return levels_[index]; }
  // The finest level whose longer side is at most one and a half times `longer_side`, pixels; the coarsest if none is.
  [[nodiscard]] std::uint32_t level_near(std::uint32_t longer_side) const;
  // Returns whether the photograph has a colour at an image position: whether all pixels that color() reads there are
  // valid. At such a position no level interpolates black, except in an odd last row or column.
  [[nodiscard]] bool is_valid(const glm::dvec2& image) const;
  // Takes another copy of the same photograph for level 0, also where the first is gone; std::invalid_argument if its
  // size is another.
  void refer_to(const PhotographSpan& copy);
  // Bilinear between pixel centres. Beyond the outermost centres the colour is theirs, and the derivative across the
  // border 0. `image` is finite and in pixels of the full resolution. These two and level() are called for each point
  // of each photograph and do not check that the level is below levels().
  [[nodiscard]] glm::dvec3 color(std::uint32_t level, const glm::dvec2& image) const;
  [[nodiscard]] ColorSample sample(std::uint32_t level, const glm::dvec2& image) const;
  // Has the processor fetch what these two are about to read. Which photograph comes next, it cannot guess, and it
  // waits for memory far longer than it computes.
  void prefetch(std::uint32_t level, const glm::dvec2& image) const;

 private:
  std::vector<PhotographSpan> levels_;
  std::vector<std::shared_ptr<const StoredPhotograph>> reduced_;  // keep the levels from 1 on, for all copies of this
};

}  // namespace lumatlas
