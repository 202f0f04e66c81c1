// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/view_mask.h"

#include <utility>

namespace lumatlas {

std::shared_ptr<const ViewMask> make_view_mask(const Photograph& photograph, std::vector<float> depth,
                                               std::vector<std::uint8_t> trust, const ValidityOptions& options) {
  auto mask = std::make_shared<ViewMask>();
  mask->depth = std::move(depth);
  mask->trust = std::move(trust);
  mask->validity = validity_mask(photograph, mask->depth, mask->trust, options);
  mask->rim = rim_pixels(photograph, mask->depth, options);
  return mask;
}

}  // namespace lumatlas
