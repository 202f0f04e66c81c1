// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/refinement/originals.h"

#include <algorithm>
#include <filesystem>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

WarnOfOriginals warning_of_originals(const BuildOptions& options) {
  if (!options.watch) return {};
  if (!options.watch->warn) return [](const std::string&) {};
  return options.watch->warn;
}

SceneView& view_named(std::vector<SceneView>& views, const std::string& name) {
  return *std::find_if(views.begin(), views.end(), [&](const SceneView& view) { return view.name == name; });
}

void require_original(const SceneView& view) {
  const auto require_size = [&](const std::filesystem::path& file, Orientation orientation) {
    const ImageSize size = photograph_size(file, orientation);
    if (size.width == view.camera.width && size.height == view.camera.height) return;
    throw InputError(file.string() + ": is " + size_text(size.width, size.height) + " pixels now, not " +
                     size_text(view.camera.width, view.camera.height));
  };
  require_size(view.image, view.orientation);
  if (view.mask) require_size(*view.mask, Orientation::as_stored);
}

}  // namespace lumatlas
