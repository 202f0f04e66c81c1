// SPDX-License-Identifier: GPL-3.0-or-later
// Several files in one answer, for a page that needs some hundred small ones at once: each request of its own costs a
// way to the server and back, and the browser some milliseconds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tools/viewer/site.h"

namespace lumatlas {

// Bounds the files of an answer, because their bytes are copied for each client that asks.
inline constexpr std::size_t kMostBytesTogether = std::size_t{4} << 20;
// Stands in place of a length for a file that is not in the answer.
inline constexpr std::uint32_t kNotTogether = 0xFFFFFFFF;

// Returns the file of that name; null: there is none.
using FindSiteFile = std::function<std::shared_ptr<const SiteFile>(const std::string& name)>;

// Returns the files that a query names, NAME&NAME..., in their order: for each the number of its bytes in 4 bytes, the
// least significant first, and these bytes; or kNotTogether alone where there is no such file, where it is on a disk,
// was named before, or would make the files larger than kMostBytesTogether.
[[nodiscard]] std::vector<std::uint8_t> files_together(std::string_view query, const FindSiteFile& find);

}  // namespace lumatlas
