// SPDX-License-Identifier: GPL-3.0-or-later
// The part of the mesh that a camera sees: depth and cell per pixel (paper section 3.2: the cell id buffer).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "mesh/base/id.h"
#include "mesh/camera/camera.h"
#include "mesh/cells/cells.h"
#include "mesh/mesh.h"

namespace lumatlas {

// Row by row from the top left, sampled at pixel centres.
struct VisibilityBuffer {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<float> depth;  // z in the camera frame; infinity where no surface is
  std::vector<FaceId> face;  // FaceId::none where no surface is
};

// Finds the visible surface. All implementations agree, except at silhouettes.
// Faces are seen from both sides. Safe to call from several threads at once.
class Visibility {
 public:
  virtual ~Visibility() = default;
  // At the camera's own resolution: pass camera.scaled_to(...) for another. Reuses the buffer's memory. Throws
  // std::invalid_argument for a bad camera (camera.h).
  virtual void trace(const Camera& camera, VisibilityBuffer& buffer) const = 0;
  [[nodiscard]] VisibilityBuffer trace(const Camera& camera) const;
  // Fills the pixels for which `wanted` is not 0 as trace() does, in less time, if the implementation can. The others
  // get any values. Throws std::invalid_argument unless `wanted` has one value per pixel.
  virtual void trace_wanted(const Camera& camera, std::span<const std::uint8_t> wanted, VisibilityBuffer& buffer) const;
  // Does nearly the same as trace() in less time, if the implementation can. Where the surface is smooth, a pixel's
  // depth may be interpolated, which is within 3e-4 of the exact one at 99 of 100 pixels, and its face may be a
  // neighbouring pixel's. A part of the surface thinner than two pixels may be missed.
  virtual void trace_sparsely(const Camera& camera, VisibilityBuffer& buffer) const;
  [[nodiscard]] VisibilityBuffer trace_sparsely(const Camera& camera) const;
};

// Throws std::invalid_argument unless there is one value per pixel.
void require_one_per_pixel(std::span<const std::uint8_t> wanted, const Camera& camera);

// Casts rays with Embree. Keeps a copy of what it needs. Throws std::invalid_argument if the mesh breaks a rule of
// mesh.h or has no faces, std::runtime_error if Embree refuses it.
[[nodiscard]] std::unique_ptr<Visibility> make_ray_visibility(const Mesh& mesh);

struct CellPixels {
  CellId cell;
  std::uint32_t pixels;  // >= 1
};

// Returns how many pixels each visible cell has in the buffer, by ascending cell. Throws std::invalid_argument if the
// buffer shows a face that `cells` does not know, or a face is in no cell.
[[nodiscard]] std::vector<CellPixels> count_cell_pixels(const VisibilityBuffer& buffer, const Cells& cells);

}  // namespace lumatlas
