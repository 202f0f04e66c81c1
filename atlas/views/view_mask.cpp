// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/views/view_mask.h"

#include <utility>

namespace lumatlas {

std::shared_ptr<const ViewMask> make_view_mask(const StoredPhotograph& photograph, std::vector<float> depth,
                                               std::vector<std::uint8_t> trust, const ValidityOptions& options) {
  const Photograph frame{photograph.width(), photograph.height(), {}, photograph.valid()};
  auto mask = std::make_shared<ViewMask>();
  mask->validity = validity_mask(frame, depth, trust, options);
  mask->rim = rim_pixels(frame, depth, options);
  mask->depth = std::move(depth);
  mask->trust = std::move(trust);
  return mask;
}

}  // namespace lumatlas
