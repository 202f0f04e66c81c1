// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/inspection/blind_views.h"

#include <algorithm>
#include <cstdint>

#include "mesh/base/errors.h"
#include "tools/base/interrupt.h"
#include "tools/inspection/inspection.h"

namespace lumatlas {

BlindViews blind_views(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks,
                       const Visibility& visibility) {
  constexpr std::size_t kMostLooks = 100;
  constexpr std::uint32_t kGlancePx = 160;  // longer side of the pictures
  const std::size_t step = (ranks.size() + kMostLooks - 1) / kMostLooks;
  BlindViews result;
  VisibilityBuffer buffer;
  for (std::size_t i = 0; i < ranks.size(); i += step, ++result.looks) {
    throw_if_interrupted();
    const SceneView& view = views[ranks[i]];
    visibility.trace(view.camera.shrunk_to(kGlancePx), buffer);
    const auto empty = static_cast<std::size_t>(std::count(buffer.face.begin(), buffer.face.end(), kNoFace));
    const std::size_t seen = buffer.face.size() - empty;
    if (static_cast<double>(seen) >= kLittleSeen * static_cast<double>(buffer.face.size())) continue;
    if (result.blind++ == 0) result.first = view.name;
  }
  return result;
}

void require_seen(const std::filesystem::path& mesh_file, const BlindViews& views, const std::string& likely) {
  if (4 * views.blind <= 3 * views.looks) return;
  throw InputError(
      mesh_file.string() + ": " + std::to_string(views.blind) + " of " + std::to_string(views.looks) +
      " views that were looked through see next to nothing of it: " +
      (likely.empty() ? "mesh and cameras are in different coordinates, or the mesh is the wrong one" : likely) +
      " (see lumatlas inspect; --any-mesh builds all the same)");
}

}  // namespace lumatlas
