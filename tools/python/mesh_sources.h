// SPDX-License-Identifier: GPL-3.0-or-later
// The sources of a mesh by their names in Python.
#pragma once

#include <array>
#include <string>
#include <utility>

#include "tools/meshing/scene_mesh.h"
#include "tools/python/names.h"

namespace lumatlas::python {

// Throws std::invalid_argument for a name that is none.
[[nodiscard]] inline MeshSource mesh_source(const std::string& name) {
  static const std::array<std::pair<std::string, MeshSource>, 3> kSources{
      {{"photographs", MeshSource::photographs}, {"depth", MeshSource::depth_images}, {"points", MeshSource::points}}};
  return value_named(kSources, "source", name);
}

}  // namespace lumatlas::python
