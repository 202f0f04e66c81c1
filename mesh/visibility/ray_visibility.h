// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility by ray casting, for callers that need only a part of a picture.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "mesh/base/pixel_rect.h"
#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// Returns the pixels that trace_part() looks at for a part of the camera's image: some more on all sides.
[[nodiscard]] PixelRect window_for_part(const Camera& camera, const PixelRect& part);

struct TracedParts;

class RayVisibility final : public Visibility {
 public:
  // Throws what make_ray_visibility() does.
  explicit RayVisibility(const Mesh& mesh);
  // For GrowingVisibility: casts rays at parts of a mesh that stand already.
  explicit RayVisibility(TracedParts parts);
  ~RayVisibility() override;

  using Visibility::trace;
  void trace(const Camera& camera, VisibilityBuffer& buffer) const override;
  void trace_wanted(const Camera& camera, std::span<const std::uint8_t> wanted,
                    VisibilityBuffer& buffer) const override;
  using Visibility::trace_sparsely;
  void trace_sparsely(const Camera& camera, VisibilityBuffer& buffer) const override;
  // Fills the buffer, which gets the window's size, with a window of what trace_sparsely() sees: the same to the bit
  // where `wanted`, one value per pixel of the window, is not 0; no surface elsewhere. The window is that of
  // window_for_part() for all wanted pixels, or larger. Takes the less time the less there is to see. Throws
  // std::invalid_argument if the window is not within the image or not at whole squares, and for another number of
  // values.
  void trace_part(const Camera& camera, const PixelRect& window, std::span<const std::uint8_t> wanted,
                  VisibilityBuffer& buffer) const;

 private:
  class Tree;
  std::unique_ptr<const Tree> tree_;
};

}  // namespace lumatlas
