// SPDX-License-Identifier: GPL-3.0-or-later
// A model whose surface comes in pieces, so that no program need hold all of it: a city's, whose blocks are made one by
// one. write_form() and write_model() take it in the place of a snapshot.
#pragma once

#include <cstddef>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "atlas/base_texture.h"
#include "atlas/fade_zones.h"
#include "atlas/snapshot.h"

namespace lumatlas {

// A part of a surface, with what lies around it. Faces, vertices and cells have the piece's own numbers.
struct SurfacePiece {
  // References are to the view slots of the whole model; the piece's own views, gains and tiles are not looked at.
  Snapshot snapshot;
  // The near cells of each chunk of the part, ascending. The others lie around it: faces of the part may fade into
  // them.
  std::vector<std::vector<CellId>> chunks;
  std::optional<CellShares> shares;  // of all faces; none: cells do not fade into each other
  // The base texture of each chunk, of its faces in their order; null: a chunk has none. As many as chunks, or none.
  std::vector<std::shared_ptr<const BaseTexture>> textures;
};

struct PiecewiseSurface {
  std::size_t chunks = 0;  // of all pieces, at least 1
  glm::dvec3 offset{0.0};  // as Surface::offset; each piece has the same
  double cell_size = 0;    // Cells::size, at most the diagonal of the box around the near surface
  // depth_before_far() of the first piece, which has the far sphere, if there is one.
  float before_far = std::numeric_limits<float>::infinity();
  std::function<SurfacePiece()> next;  // returns one piece after the other; their chunks, cells and faces follow so
};

struct PiecewiseModel {
  // Has the model's views, gains and tiles, and the references of all its cells. The writer reads no other table of it.
  // Each view has a resident tile.
  Snapshot whole;
  PiecewiseSurface surface;
};

}  // namespace lumatlas
