// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: where the writer of a model takes its chunks from.
#pragma once

#include <cstddef>
#include <memory>

#include "atlas/model/model_form.h"
#include "atlas/model/model_parts.h"
#include "atlas/model/piecewise_model.h"
#include "atlas/model/surface/surface_chunks.h"

namespace lumatlas {

class ChunkSource {
 public:
  virtual ~ChunkSource() = default;
  [[nodiscard]] virtual std::size_t count() const = 0;  // at least 1
  // Returns a chunk. The writer asks for each number once, ascending, so that a source need hold no more than one.
  [[nodiscard]] virtual SurfaceChunk chunk(std::size_t number) = 0;
};

// Cuts the surface of a snapshot into chunks as the options say. All must live as long as the source.
[[nodiscard]] std::unique_ptr<ChunkSource> whole_surface(const ModelParts& model, const FormOptions& options);
// Takes the chunks of a surface that comes in pieces. Throws std::invalid_argument for a piece whose tables do not fit
// together or to the model.
[[nodiscard]] std::unique_ptr<ChunkSource> surface_in_pieces(const ModelParts& model, const PiecewiseSurface& surface,
                                                             const FormOptions& options);

}  // namespace lumatlas
