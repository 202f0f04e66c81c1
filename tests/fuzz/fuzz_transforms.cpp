// SPDX-License-Identifier: GPL-3.0-or-later
// transforms.json: what is read has poses and lenses that the program can work with.
#include <cmath>

#include "tests/fuzz/laws/capture_laws.h"
#include "tests/fuzz/laws/sentence_laws.h"
#include "tools/scene/forms/transforms_json.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lumatlas;
  check_refusal([&] {
    const Capture read = parse_transforms(text_of(data, size), "transforms.json",
                                          {[](const std::filesystem::path& file) { return file; },
                                           [](const PosedPhotograph&) {
                                             return ImageSize{64, 48};
                                           }});
    require(!read.photographs.empty());
    for (const PosedPhotograph& frame : read.photographs) {
      check(frame.lens);
      require(std::abs(glm::length(frame.cam_from_world_rotation) - 1) < 1e-9);
      require(std::isfinite(glm::length(frame.cam_from_world_translation)));
      require(!frame.name.empty());
    }
    require_inside(read);
  });
  return 0;
}
