// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: areas by CGAL, kept away from the other files because its kernels compile slowly.
#pragma once

#include <vector>

#include "mesh/mesh.h"

namespace lumatlas {

[[nodiscard]] std::vector<double> face_areas(const Mesh& mesh);  // per face, scene units squared

}  // namespace lumatlas
