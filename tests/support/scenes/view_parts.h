// SPDX-License-Identifier: GPL-3.0-or-later
// Changes the parts of a stored view, which views share and never change themselves.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "atlas/views/stored_view.h"

namespace lumatlas {

// Gives the view another photograph: a copy of its own (empty where it has none) that `change` has changed.
template <typename Change>
void change_photograph(StoredView& view, const Change& change) {
  Photograph photograph = view.photograph ? view.photograph->whole() : Photograph();
  change(photograph);
  view.photograph = std::make_shared<const StoredPhotograph>(std::move(photograph));
}

// Changes each value of red, green and blue.
template <typename Change>
void change_colors(StoredView& view, const Change& change) {
  change_photograph(view, [&](Photograph& photograph) {
    for (std::uint8_t& value : photograph.rgb) value = static_cast<std::uint8_t>(change(value));
  });
}

// Gives the view a copy of its mask (empty where it has none), and returns the copy to be changed. The reference is
// good until the view is assigned or destroyed.
inline ViewMask& own_mask(StoredView& view) {
  auto mask = view.mask ? std::make_shared<ViewMask>(*view.mask) : std::make_shared<ViewMask>();
  view.mask = mask;
  return *mask;
}

}  // namespace lumatlas
