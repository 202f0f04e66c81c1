// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility of a mesh that changes in places, version by version.
//
//   GrowingVisibility visibility(0.5);
//   std::unique_ptr<Visibility> first = visibility.of(mesh), second = visibility.of(mesh_with_another_corner);
#pragma once

#include <cstddef>
#include <memory>

#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

class GrowingVisibility {
 public:
  // The mesh is divided by cubes of this side, scene units, finite, > 0 (std::invalid_argument): a face is in the cube
  // of its first corner. A quarter of the distance that the surface is seen from is a good side.
  explicit GrowingVisibility(double side);
  ~GrowingVisibility();
  GrowingVisibility(const GrowingVisibility&) = delete;
  GrowingVisibility& operator=(const GrowingVisibility&) = delete;

  // Returns what make_ray_visibility() returns of the mesh, except that depths may differ in the last bit. A cube whose
  // faces are those of the version before, to the bit and in the same order, takes no time but that of the comparison.
  // The result may outlive this object and is safe to use while the next version is made. Throws what
  // make_ray_visibility() does.
  [[nodiscard]] std::unique_ptr<Visibility> of(const Mesh& mesh);
  // Returns how many cubes the last call of of() had, and how many of these it made anew.
  [[nodiscard]] std::size_t cubes() const;
  [[nodiscard]] std::size_t cubes_made() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lumatlas
