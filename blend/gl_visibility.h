// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility on the GPU: face and depth of every pixel by rasterising the mesh.
#pragma once

#include <memory>

#include "mesh/cells/cells.h"
#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

struct GlVisibilityOptions {
  // Cells whose bounding sphere is out of view are not drawn; the buffer is the same without. Cells that face away are
  // drawn: a surface is seen, and hides others, from both of its sides.
  bool frustum_culling = true;
  bool debug = false;  // see EglContext::Options
};

// Like make_ray_visibility(). The two differ at silhouettes and where faces meet, because a rasteriser moves corners to
// the nearest 1/256 of a pixel. Mesa's depths are within 1e-4 of the rays', most within 1e-6; on a face thousands of
// times larger than its distance from the camera they are worse. NVIDIA's are computed from the moved corners, and are
// off by up to 2e-3 where a face is seen nearly edge-on. There is no near or far plane. A camera with numbers that
// floats cannot hold sees nothing.
//
// It has a GL context of its own, which is current only while a call lasts, on the thread that calls: other contexts,
// and other objects like this one, may be current before and after. Calls from several threads wait for each other.
//
// Copies what it needs. Throws std::invalid_argument if the mesh has no faces, one of them has a corner that is no
// vertex, or the cells are not the mesh's. Throws GlError if there is no OpenGL 4.5 or the mesh does not fit. trace()
// throws GlError for a picture above the driver's texture size or 2^29 pixels.
[[nodiscard]] std::unique_ptr<Visibility> make_gl_visibility(const Mesh& mesh, const Cells& cells,
                                                             const GlVisibilityOptions& options = {});

}  // namespace lumatlas
