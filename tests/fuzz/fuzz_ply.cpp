// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/readers/ply_reader.h"
#include "tests/fuzz/laws/soup_laws.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  lumatlas::check_soup_laws(lumatlas::parse_ply, data, size);
  return 0;
}
