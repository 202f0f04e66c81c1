// SPDX-License-Identifier: GPL-3.0-or-later
// Camera paths: what is read can be flown along.
#include <cmath>

#include "tests/fuzz/laws/sentence_laws.h"
#include "tools/picture/paths/path_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  lumatlas::write_input("path.json", lumatlas::text_of(data, size));
  lumatlas::check_refusal([] {
    const lumatlas::CameraPath path(lumatlas::read_path("path.json", {}));
    for (const double share : {0.0, 0.3, 1.0}) {
      const lumatlas::Vantage at = path.at(path.begin() + share * (path.end() - path.begin()));
      lumatlas::require(std::isfinite(at.position.x + at.position.y + at.position.z));
      lumatlas::require(std::abs(glm::length(at.cam_from_world) - 1) < 1e-6);
      lumatlas::require(at.fov_deg > 0 && at.fov_deg < 180);
    }
  });
  return 0;
}
