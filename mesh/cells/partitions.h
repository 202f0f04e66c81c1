// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: the two ways to divide the faces into cells. Both return a label per face, not numbered densely.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/cancel_check.h"
#include "mesh/face_geometry.h"
#include "mesh/mesh.h"

namespace lumatlas {

// Faces by the cube, world-aligned and with this edge, that holds their centroid.
[[nodiscard]] std::vector<std::uint32_t> grid_labels(const Mesh& mesh, double size);

// Connected clusters of about size^2 each. `geometry` holds one per face.
[[nodiscard]] std::vector<std::uint32_t> cluster_labels(const Mesh& mesh, std::span<const FaceGeometry> geometry,
                                                        double size, double normal_weight,
                                                        const CancelCheck& cancel_check = {});

}  // namespace lumatlas
