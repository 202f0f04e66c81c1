// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/content_digest.h"

#include <OpenImageIO/hash.h>

namespace lumatlas {

std::uint64_t content_digest(std::span<const std::byte> bytes) {
  return OIIO::xxhash::XXH64(bytes.data(), bytes.size(), 0);
}

}  // namespace lumatlas
