// SPDX-License-Identifier: GPL-3.0-or-later
// How deep a stored view looks, by which a page scales what it draws of it.
#pragma once

#include "atlas/stored_view.h"

namespace lumatlas {

// Of a view's finite depths, looked at on every 16th pixel that has one; scene units, 0 if none has.
[[nodiscard]] double median_depth(const StoredView& view);

}  // namespace lumatlas
