// SPDX-License-Identifier: GPL-3.0-or-later
// ICC profiles in sound PNG and TIFF files. The fuzzer of images seldom reaches them: a PNG has a checksum over a
// packed profile.
#include "atlas/images/photograph.h"
#include "tests/fuzz/laws/sentence_laws.h"
#include "tests/support/profiled_pictures.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lumatlas;
  const std::string_view profile = text_of(data, size);
  const auto require_read = [](const std::string& bytes) {
    write_input("input", bytes);
    require(photograph_size("input").width == kProfiledSide);
    require(read_photograph("input").height == kProfiledSide);
  };
  require_read(png_with_profile(profile));
  require_read(png_with_profile_chunk(profile));
  require_read(tiff_with_profile(profile));
  return 0;
}
