// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of the photographs of a capture of any form.
#pragma once

#include <utility>

#include "tests/fuzz/laws/sentence_laws.h"
#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/photographs/find_photographs.h"

namespace lumatlas {

// Once photographs were looked for, in a folder that has none, no name and no file leads out of its folder.
inline void require_inside(Capture capture) {
  if (capture.photographs.empty()) return;
  find_photographs(capture, "form", "/nonexistent", std::nullopt, BadPhotographs::keep);
  for (const PosedPhotograph& photograph : capture.photographs) {
    require(inner_path(photograph.name).has_value() && inner_path(photograph.file.string()).has_value());
  }
}

}  // namespace lumatlas
