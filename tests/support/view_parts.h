// SPDX-License-Identifier: GPL-3.0-or-later
// Changes the parts of a stored view, which views share and never change themselves.
#pragma once

#include <memory>

#include "atlas/stored_view.h"

namespace lumatlas {

// Gives the view a copy of its part (empty where it has none), and returns the copy to be changed. The reference is
// good until the view is assigned or destroyed.
inline Photograph& own_photograph(StoredView& view) {
  auto photograph = view.photograph ? std::make_shared<Photograph>(*view.photograph) : std::make_shared<Photograph>();
  view.photograph = photograph;
  return *photograph;
}
inline ViewMask& own_mask(StoredView& view) {
  auto mask = view.mask ? std::make_shared<ViewMask>(*view.mask) : std::make_shared<ViewMask>();
  view.mask = mask;
  return *mask;
}

}  // namespace lumatlas
