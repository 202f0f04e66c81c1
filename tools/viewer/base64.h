// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>

namespace lumatlas {

// RFC 4648, with padding.
void write_base64(std::ostream& out, std::span<const std::uint8_t> bytes);

}  // namespace lumatlas
