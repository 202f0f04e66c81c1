// SPDX-License-Identifier: GPL-3.0-or-later
// Cells: the unit of view planning and of the renderer's view references. Erat et al. 2019, section 3.2, use a regular
// grid; here a cell is a cluster of mesh faces, with the grid kept for comparison.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "mesh/base/id.h"
#include "mesh/cancel_check.h"
#include "mesh/mesh.h"

namespace lumatlas {

enum class Partition {
  clusters,  // connected, compact, normal-coherent clusters of faces
  grid,      // the paper's: faces by the grid cube that holds their centroid
};

struct CellOptions {
  Partition partition = Partition::clusters;
  // Target diameter of a cell, scene units; a cell's area is about size^2 where the surface is smooth (the median
  // within 30%, no radius above 1.5 size) and less where it bends. 0: automatic_cell_size(). Smaller: more cells, finer
  // choice of views.
  double size = 0;
  // Strength with which a cluster avoids turning: the cost of a face is its distance from the cluster's centre, in cell
  // sizes, plus this times (1 - cos) of the angle between its normal and the cluster's. >= 0; clusters only.
  double normal_weight = 2;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const CellOptions& options);

struct Cell {
  glm::dvec3 centroid{0.0};    // area-weighted
  glm::dvec3 normal{0.0};      // unit mean normal, area-weighted; zero where the normals cancel
  double normal_cone_cos = 1;  // every face's normal n has dot(n, normal) >= this; -1 where normal is zero
  double area = 0;             // scene units squared, by CGAL
  double radius = 0;           // every vertex is within this of the centroid
  std::uint32_t faces = 0;     // how many, >= 1
};

struct Cells {
  double size = 0;                   // the target that was used, scene units
  std::vector<Cell> cells;           // none is empty
  std::vector<CellId> cell_of_face;  // one per face of the mesh
};

// Returns the size that CellOptions::size = 0 stands for: scene_diameter() / 60 (data/results/cell-size.csv; the paper
// finds 1/100 to 1/30 of the scene). 0 for a mesh without area.
[[nodiscard]] double automatic_cell_size(const Mesh& mesh);

// Returns the cells of a mesh, numbered by their first face, the same bytes for any number of threads. The mesh's faces
// should be no larger than a cell (split_large_faces with the options' size). A cluster is connected over manifold
// edges: it ends at an edge where more than two faces meet, or two that turn against each other. A cluster much smaller
// than the target remains only if it fits no neighbour. Throws std::invalid_argument for bad options, if the
// mesh breaks a rule of mesh.h, or if the size is automatic and the faces have no area.
[[nodiscard]] Cells make_cells(const Mesh& mesh, const CellOptions& options, const CancelCheck& cancel_check = {});

// Returns the cells of a partition that is known already, with their statistics; `cell_of_face` numbers them. `size` is
// passed on. Throws std::invalid_argument if the mesh breaks a rule of mesh.h, unless `cell_of_face` has one entry per
// face and numbers the cells from 0 without gaps, and unless `size` is finite and not negative.
[[nodiscard]] Cells measure_cells(const Mesh& mesh, std::vector<CellId> cell_of_face, double size);

}  // namespace lumatlas
