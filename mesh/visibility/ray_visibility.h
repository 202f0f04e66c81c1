// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility by ray casting, for callers that need only a part of a picture.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

class RayVisibility final : public Visibility {
 public:
  // Throws what make_ray_visibility() does.
  explicit RayVisibility(const Mesh& mesh);
  ~RayVisibility() override;

  using Visibility::trace;
  void trace(const Camera& camera, VisibilityBuffer& buffer) const override;
  using Visibility::trace_sparsely;
  void trace_sparsely(const Camera& camera, VisibilityBuffer& buffer) const override;
  // The same to the bit as trace_sparsely() where `wanted`, one value per pixel (std::invalid_argument otherwise), is
  // not 0; no surface elsewhere. The fewer pixels are wanted, the less time it takes.
  void trace_part(const Camera& camera, std::span<const std::uint8_t> wanted, VisibilityBuffer& buffer) const;

 private:
  class Tree;
  std::unique_ptr<const Tree> tree_;
};

}  // namespace lumatlas
