// SPDX-License-Identifier: GPL-3.0-or-later
// Finds which known name a user who mistyped one may have meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace lumatlas {

// The fewest characters to insert, delete, exchange or swap with their neighbour that lead from `a` to `b`.
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

// The one of `names` that is nearest to `typed`, the first of several; "" if all are further away than a third of its
// characters, or than one of a short name.
[[nodiscard]] std::string nearest_name(std::string_view typed, const std::vector<std::string>& names);

}  // namespace lumatlas
