// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the ZoneMesh of a batch on the GPU.
#pragma once

#include "blend/gl/gl_objects.h"
#include "blend/tables/zone_mesh.h"

namespace lumatlas {

struct MeshObjects {
  GlBuffer positions, colors, shares, zone_numbers, faces;
  GlVertexArray vertices;
};

// Makes `vertices` of the buffers, as shaders/surface.vert reads them. Throws GlError.
void make_vertices(MeshObjects& objects);

// Copies all at once.
[[nodiscard]] MeshObjects make_mesh_objects(const ZoneMesh& mesh);

}  // namespace lumatlas
