// SPDX-License-Identifier: GPL-3.0-or-later
// Counts the bytes that a model takes on the GPU: all buffers and textures that Renderer makes of it, to the byte.
// Render targets are not counted. Needs no context, so that a build can bound the model's size.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "atlas/snapshot.h"
#include "blend/blend_options.h"

namespace lumatlas {

struct CellShares;

// All in bytes.
struct GpuBytes {
  std::uint64_t mesh = 0;      // positions and faces
  std::uint64_t vertices = 0;  // colours where no view is valid, shares of cells, zones
  std::uint64_t tables = 0;    // zones, cells, references, views, tiles
  std::uint64_t depth = 0;     // the stored views' depths
  std::uint64_t masks = 0;     // their validity, which is the alpha of their colours
  std::uint64_t colors = 0;    // coarser levels included

  [[nodiscard]] std::uint64_t sum() const { return mesh + vertices + tables + depth + masks + colors; }
  [[nodiscard]] std::uint64_t photographs() const { return depth + masks + colors; }
};

// Counts the bytes of any model on one surface. The slow part depends on the surface alone and is done once.
class GpuByteCount {
 public:
  // `border_width` as in BlendOptions, on which it depends how often a vertex is there. Throws std::invalid_argument
  // unless there is a surface and the width is finite and >= 0.
  explicit GpuByteCount(std::shared_ptr<const Surface> surface, double border_width = BlendOptions{}.border_width);

  // Counts the bytes of a model that is loaded once, with `references` of each of the surface's cells, `views` and
  // `tiles` resident tiles; `layout.max_tiles` is ignored. Texture arrays are laid out by the limits that OpenGL 4.5
  // guarantees. Other limits change the count of some models of gigabytes by a few tile places. Throws
  // std::invalid_argument unless the layout passes check() and there is a list of references for each cell.
  [[nodiscard]] GpuBytes of(const ReferenceTable& references, std::span<const Camera> views, const TileOptions& layout,
                            std::uint32_t resident_tiles) const;
  [[nodiscard]] GpuBytes of(const ReferenceTable& references, std::span<const Camera> views,
                            const TileTable& tiles) const;
  // Counts the bytes of the model as its file holds it: with the views that are there, and as many tile places as are
  // resident.
  [[nodiscard]] GpuBytes of(const Snapshot& snapshot) const;
  // Returns the bytes of mesh and tables without any view, which no choice of views saves.
  [[nodiscard]] std::uint64_t of_surface() const;

 private:
  std::shared_ptr<const Surface> surface_;
  double border_width_;
  std::shared_ptr<const CellShares> shares_;
};

}  // namespace lumatlas
