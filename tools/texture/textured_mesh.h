// SPDX-License-Identifier: GPL-3.0-or-later
// A model's mesh with a conventional texture: one colour for each place of the surface, for programs that know nothing
// of views.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "atlas/images/photograph.h"
#include "atlas/snapshot.h"
#include "mesh/cancel_check.h"
#include "tools/texture/layout/charts.h"
#include "tools/texture/layout/texture_layout.h"
#include "tools/texture/placed_photographs.h"
#include "tools/texture/surface_color.h"

namespace lumatlas {

struct TextureOptions {
  ChartOptions charts;
  LayoutOptions layout;
  ColorOptions color;
  // Texels per pixel of the median view that sees a cell. (0, 4]
  double texels_per_pixel = 1;
  // Bounds memory while photographs come one after the other, 36 bytes a texel: beyond it they are read again. >= 1
  std::uint64_t most_texels_at_once = 1u << 24;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const TextureOptions& options);

struct TextureFacts {
  std::uint64_t texels = 0;         // that show a place of the surface
  std::uint64_t unseen_texels = 0;  // how many of these no view sees: they have the vertices' colours
  double texels_per_pixel = 0;      // along a side: what was asked for, or less where the pages bound it
  std::size_t photographs = 0;      // that the colours are of
  std::size_t outliers = 0;         // that were offered, but do not show what the model does
};

// Makes pages one after the other, so that memory holds one of them. Charts are made in groups that have few texels.
// Its bytes do not depend on the number of threads.
class TexturedMesh {
 public:
  // Lays the texture out. Keeps the snapshot. With photographs `offered` they give the colours too, else only what is
  // in the snapshot does. Throws std::invalid_argument for bad options or a snapshot that does not pass check(),
  // ChartsDoNotFit.
  TexturedMesh(const Snapshot& snapshot, const TextureOptions& options, OfferedPhotographs offered = {});

  [[nodiscard]] const Mesh& mesh() const { return snapshot_.surface->mesh; }
  [[nodiscard]] const Snapshot& snapshot() const { return snapshot_; }
  [[nodiscard]] const std::vector<Chart>& charts() const { return charts_; }
  [[nodiscard]] const TextureLayout& layout() const { return layout_; }
  [[nodiscard]] const std::vector<std::uint32_t>& chart_of_face() const { return chart_of_face_; }

  // The pages in order, sRGB. `cancel_check` is called ticks() times, from any thread. Throws what reading photographs
  // does.
  using PageSink = std::function<void(std::uint32_t page, const Photograph& picture)>;
  TextureFacts bake(const PageSink& sink, const CancelCheck& cancel_check = {}) const;
  [[nodiscard]] std::size_t ticks() const;

 private:
  [[nodiscard]] TextureFacts bake_stored(const PageSink& sink, const CancelCheck& cancel_check) const;
  [[nodiscard]] TextureFacts bake_offered(const PageSink& sink, const CancelCheck& cancel_check) const;
  [[nodiscard]] std::vector<std::uint32_t> charts_on(std::uint32_t page) const;
  // Charts of a page whose texels are gathered together.
  [[nodiscard]] std::vector<std::vector<std::uint32_t>> batches_on(std::uint32_t page) const;

  Snapshot snapshot_;
  TextureOptions options_;
  OfferedPhotographs offered_;
  TextureViews views_;
  std::vector<Chart> charts_;
  TextureLayout layout_;
  std::vector<std::uint32_t> chart_of_face_;
};

}  // namespace lumatlas
