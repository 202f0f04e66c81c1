// SPDX-License-Identifier: GPL-3.0-or-later
// Repair of a soup that changes in places, version by version: only faces near a change are looked at again.
//
//   GrowingRepair repair;
//   GrownMesh first = repair.next({soup, {}});
//   GrownMesh second = repair.next({soup_with_a_hole, previous_position});
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "mesh/base/id.h"
#include "mesh/mesh.h"

namespace lumatlas {

// A version of a soup, without colours, and which of its positions were there in the version before.
struct GrownSoup {
  TriangleSoup soup;
  // For each position the one before that it was, which had the same coordinates; VertexId::none: it is new.
  // No two name the same. Empty: all are new. A face whose corners were those of a face before, in the same turn, is
  // that face.
  std::vector<VertexId> previous_position;
  // For each face the one before that it was, with the same corners in the same order; FaceId::none: it is new, or its
  // maker has not looked. Ascending without those. Empty: its maker has looked at none. Saves the search for it.
  std::vector<FaceId> previous_face = {};
};

// A version of the repaired mesh.
struct GrownMesh {
  Mesh mesh;
  std::vector<FaceId> previous_face;  // for each face which one of the mesh before it was; FaceId::none: it is new
};

class GrowingRepair {
 public:
  GrowingRepair();
  ~GrowingRepair();
  GrowingRepair(const GrowingRepair&) = delete;
  GrowingRepair& operator=(const GrowingRepair&) = delete;

  // Returns what repair() makes of the soup without an offset, except for the order of the vertices: they come in the
  // order in which faces use them first. The mesh follows from the soup alone, to the bit. `previous_position` and
  // `previous_face` refer to the soup of the last call that returned. Time: that of repair() for the faces around
  // positions at which a face came or went, and a small share of that for all others. Where faces turn against each
  // other, as a soup of several scans may have them, a few passes over all faces besides. That of repair() for all
  // faces where faces that stay have changed their order, because of faces between the same three points the first one
  // is kept. Throws InputError if no face is left, and std::invalid_argument for a soup with colours, with a face that
  // refers to no position, or with more than 5e8 faces or positions, and unless `previous_position` is empty or has one
  // entry per position, each a position that was there, and `previous_face` is as described. This stays as it was then.
  [[nodiscard]] GrownMesh next(GrownSoup grown);
  // Returns how many faces the last call looked at again.
  [[nodiscard]] std::size_t faces_repaired() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lumatlas
