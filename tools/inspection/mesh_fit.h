// SPDX-License-Identifier: GPL-3.0-or-later
// Tests whether the mesh of a scene and its photographs belong together, and if not, finds what is likely to be wrong.
//
// Some photographs are made small. Points of the mesh that one of them shows are looked up in the others, by the poses
// and depths as given, and the colours are compared. Two figures say how well they agree:
//
//   correlation  of luma in a band of wavelengths: detail of about 2 to 8 of the small pixels. Chance gives 0, whatever
//                the photographs show and however they are exposed: brightness alone, a floor that is darker than the
//                walls, has no part in it.
//   residual     root of the mean robust squared difference of colour after one gain a pair, sRGB of [0, 1], and the
//                share of points that are outliers of it.
//
// Only the correlation decides (mesh_diagnosis.h): a wrong mesh has a small residual where everything is grey.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mesh/visibility/visibility.h"
#include "tools/scene/mesh/mesh_frame.h"
#include "tools/scene/scene.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {

struct MeshFitOptions {
  std::uint32_t views = 24;         // photographs that are looked at, at most, >= 2
  std::uint32_t longer_px = 160;    // longer side of the small pictures, >= 32
  std::uint32_t step_px = 4;        // between the points of a small picture, along rows and columns, >= 1
  std::uint32_t least_points = 40;  // that two photographs must share to be compared, >= 1
  double same_depth = 0.03;         // share of a point's depth by which the mesh may be before or behind it in the
                                    // other view, in (0, 1)
  double outlier = 0.15;            // difference from which on a point is an outlier, sRGB, in (0, 1)
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const MeshFitOptions& options);

struct MeshFit {
  std::size_t pairs = 0;   // photographs that share points of the mesh, each pair in both directions
  std::size_t points = 0;  // over all pairs
  double correlation = 0;  // median over the pairs, in [-1, 1]; the figures are NaN without a pair
  double residual = 0;     // over all points, sRGB
  double outliers = 0;     // share of the points, in [0, 1]
};

// A change of photographs after their poses were found: quarter turns clockwise, or mirrored.
struct PictureChange {
  std::uint32_t quarter_turns = 0;
  bool mirrored = false;
};

struct SmallPicture;

class MeshFitMeter {
 public:
  // Reads some of the photographs of these ranks, evenly, and for each of them some that were taken nearby; those that
  // cannot be read are left out. What is black in all of them along the same edges does not enter. Keeps references to
  // `views` and `visibility`. `offset` was subtracted from mesh and poses.
  MeshFitMeter(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks, const Visibility& visibility,
               const glm::dvec3& offset, const MeshFitOptions& options = {});
  ~MeshFitMeter();

  // Measures how well the photographs agree if `mesh` still has to change the mesh, with the offset.
  [[nodiscard]] MeshFit measure(const MeshFrame& mesh = {}, const PictureChange& picture = {}) const;
  // Returns the number of photographs that are looked at.
  [[nodiscard]] std::size_t pictures() const { return chosen_.size(); }
  // The share of the given points that lie on the mesh: whose depth is the mesh's to `same_place` of it, in at least
  // half of the views that saw them, or in one where it is not known which did. NaN where fewer than 50 are in the
  // pictures. Looks at 20000 of them at most.
  [[nodiscard]] double points_on_mesh(const ScenePoints& points, double same_place) const;
  // The largest share of a picture's pixels that is black in every photograph of its size and reaches its edge, as
  // undistortion leaves it; 0 where there are fewer than three photographs of any size.
  [[nodiscard]] double black_border() const { return black_border_; }

 private:
  void leave_out_borders();

  const std::vector<SceneView>& views_;
  const Visibility& visibility_;
  glm::dvec3 offset_;
  MeshFitOptions options_;
  std::vector<std::size_t> chosen_;
  std::vector<SmallPicture> pictures_;  // one for each of `chosen_`
  double black_border_ = 0;
};

}  // namespace lumatlas
