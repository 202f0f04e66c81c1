// SPDX-License-Identifier: GPL-3.0-or-later
// Charts: parts of a surface that are laid flat, each by projection along its mean normal, so that every place of the
// surface has a place of its own in a texture.
//
// Neighbouring cells of one direction become one chart. A face that is seen too obliquely along its chart's normal, or
// that would lie over another one, is taken out; such faces form charts among themselves, down to single ones. So a
// projection is enough: nothing has to be solved, and the bounds below hold for every face of every mesh.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "mesh/cells/cells.h"
#include "mesh/mesh.h"

namespace lumatlas {

struct ChartOptions {
  // Cells join a chart whose normal theirs differs from by at most so much. [0, 80]
  double merge_degrees = 30;
  // A face of a chart is seen under at most this angle from the chart's normal: it becomes smaller by the angle's
  // cosine along one direction and stays as it is along the other. [merge_degrees, 85]
  double most_degrees = 75;
  // Cells join a chart whose first cell is at most this many cell sizes away. >= 0
  double reach = 6;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const ChartOptions& options);

// The plane of a chart. A point's place on it is (dot(right, p), dot(down, p)) - least, scene units: within [0, size].
// Seen from where the normal points to, `right` and `down` are what they say.
struct Chart {
  std::vector<FaceId> faces;         // the mesh's faces, each in one chart
  glm::dvec3 right{0.0}, down{0.0};  // unit, at right angles
  glm::dvec2 least{0.0};             // scene units
  glm::dvec2 size{0.0};              // scene units; the smallest rectangle around the chart, not higher than wide

  [[nodiscard]] glm::dvec2 place(const glm::dvec3& point) const;
};

// Every face with an area is in exactly one chart, and no two faces of a chart overlap on its plane (by exact
// predicates). Faces without area are in a chart too. The order is fixed: the same bytes for any number of threads.
// Throws std::invalid_argument for bad options, if the mesh breaks a rule of mesh.h, or if the cells are not of this
// mesh.
[[nodiscard]] std::vector<Chart> make_charts(const Mesh& mesh, const Cells& cells, const ChartOptions& options = {});

}  // namespace lumatlas
