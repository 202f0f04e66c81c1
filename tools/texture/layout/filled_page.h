// SPDX-License-Identifier: GPL-3.0-or-later
// A page of a texture, whose empty texels take the colours around them.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

class FilledPage {
 public:
  explicit FilledPage(std::uint32_t side_px);  // at least 1

  // Linear light. From any thread, if no two set the same texel.
  void set(std::uint32_t x, std::uint32_t y, const glm::vec3& linear);

  // Returns the whole page, sRGB. A texel that was not set has the mean colour of the smallest square of 2^k texels
  // around it (on the grid of such squares) with a set one, so that coarser levels of the texture stay clean; black if
  // none was set. Ends the page.
  [[nodiscard]] Photograph finish();

 private:
  Photograph picture_;
  std::vector<std::uint8_t> is_set_;  // one per texel
};

}  // namespace lumatlas
