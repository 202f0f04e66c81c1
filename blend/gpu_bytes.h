// SPDX-License-Identifier: GPL-3.0-or-later
// What a model takes on the GPU: all buffers and textures that Renderer makes of it, to the byte. Targets of pictures
// are not the model's. Needs no context, so that whoever builds a model can bound it.
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
  std::uint64_t depth = 0;     // of the stored views
  std::uint64_t masks = 0;     // their validity, which is the alpha of their colours
  std::uint64_t colors = 0;    // coarser levels included

  [[nodiscard]] std::uint64_t sum() const { return mesh + vertices + tables + depth + masks + colors; }
  [[nodiscard]] std::uint64_t photographs() const { return depth + masks + colors; }
};

// Of any model on one surface. What takes time is of the surface alone, and done once.
class GpuByteCount {
 public:
  // `border_width` as in BlendOptions, on which it depends how often a vertex is there. Throws std::invalid_argument
  // unless there is a surface and the width is finite and >= 0.
  explicit GpuByteCount(std::shared_ptr<const Surface> surface, double border_width = BlendOptions{}.border_width);

  // Of a model that is loaded once, with `references` of each of the surface's cells, `views` and so many tiles
  // resident; `layout.max_tiles` does not count. Texture arrays are laid out by the limits that OpenGL 4.5 promises:
  // under others some models of gigabytes take a few slots more or less. Throws std::invalid_argument unless the layout
  // passes check() and there is a list of references for each cell.
  [[nodiscard]] GpuBytes of(const ReferenceTable& references, std::span<const Camera> views, const TileOptions& layout,
                            std::uint32_t resident_tiles) const;
  [[nodiscard]] GpuBytes of(const ReferenceTable& references, std::span<const Camera> views,
                            const TileTable& tiles) const;
  // Of the model as its file holds it: of the views that are there, and of no more slots than are resident.
  [[nodiscard]] GpuBytes of(const Snapshot& snapshot) const;
  // What no choice of views saves: mesh and tables without any.
  [[nodiscard]] std::uint64_t of_surface() const;

 private:
  std::shared_ptr<const Surface> surface_;
  double border_width_;
  std::shared_ptr<const CellShares> shares_;
};

}  // namespace lumatlas
