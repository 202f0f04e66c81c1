// SPDX-License-Identifier: GPL-3.0-or-later
// Coefficients of lenses in JSON files: those that a reader does not know would bend the picture all the same.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tools/base/strict_json.h"

namespace lumatlas {

// Returns whether a key is a name that some program uses for a coefficient or a list of these, such as "k1" or "omega".
[[nodiscard]] bool is_lens_coefficient(std::string_view key);

// Throws InputError that names the place where `find` gives a coefficient that is not in `read` and is not 0. `lens` is
// added to the sentence: " of a fisheye".
void refuse_unread_coefficients(const std::function<std::optional<JsonPlace>(std::string_view key)>& find,
                                std::span<const std::string_view> read, const std::string& lens = {});

}  // namespace lumatlas
