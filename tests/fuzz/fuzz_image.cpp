// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs: a file, told by its first bytes whatever its ending says, and the same bytes in memory, as a model's
// images are read.
#include <span>

#include "atlas/images/photograph.h"
#include "tests/fuzz/laws/sentence_laws.h"

namespace {

using namespace lumatlas;

void require_whole(const Photograph& photograph, const ImageSize& size) {
  require(photograph.width == size.width && photograph.height == size.height);
  require(photograph.rgb.size() == std::size_t{3} * size.width * size.height);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  write_input("input.jpg", text_of(data, size));
  for (const Orientation orientation : {Orientation::exif, Orientation::as_stored}) {
    check_refusal([&] {
      const ImageSize stated = photograph_size("input.jpg", orientation);
      require_whole(read_photograph("input.jpg", orientation), stated);
    });
  }
  check_refusal([&] {
    const ImageSize stated = photograph_size(std::span(data, size), "name");
    require_whole(read_photograph(std::span(data, size), "name"), stated);
  });
  return 0;
}
