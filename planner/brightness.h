// SPDX-License-Identifier: GPL-3.0-or-later
// How bright a stored view shows a point of the surface, and how that changes when its camera moves: what joint
// refinement compares. Brightness is luma, encoded about as sRGB is, so that a difference counts as much as it does to
// the eye, and so that a factor on the light is a factor on the brightness.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/camera.h"
#include "planner/median_colors.h"
#include "planner/surface_samples.h"

namespace lumatlas {

// Six numbers that move a camera: moved() by a rotation vector, and by a translation in multiples of `depth`, so that a
// unit of each moves the image about as far.
using PoseOffset = std::array<double, 6>;
struct PoseFrame {
  Camera camera;     // where the offset is 0
  double depth = 1;  // scene units, > 0
};
[[nodiscard]] Camera camera_at(const PoseFrame& frame, const PoseOffset& offset);
// What camera_at() makes `camera` from.
[[nodiscard]] PoseOffset offset_of(const PoseFrame& frame, const Camera& camera);

// A view that shows a point.
struct Sight {
  std::uint32_t slot = 0;
  // Of its pyramid, whose pixels are as large on the surface as those that the point was chosen in; may be negative.
  float level = 0;
};

// Points of the surface and the views that show them.
struct SeenPoints {
  std::vector<glm::dvec3> positions;
  std::vector<std::size_t> first = {0};  // the point i is seen by sights[first[i]] to sights[first[i + 1] - 1]
  std::vector<Sight> sights;
};

// Points that something is fitted to, and points by which the fit is judged.
struct PointSplit {
  SeenPoints fitted, held_out;
  std::vector<double> depth;          // by slot: the median of its points, scene units; 0: the view takes no part
  std::vector<std::size_t> per_view;  // by slot: how many sights of fitted points the view has
};

// Every fifth of a view's samples is held out. Of each view about `most_points` are taken, evenly. A point counts that
// at least two views show, neither too dark nor clipped: the one that it was chosen in, and one that its cell refers
// to. Views with fewer than kFewestAlignmentPoints such points take no part; others are still compared with them.
// `views` and `samples` by slot of the atlas.
[[nodiscard]] PointSplit split_points(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                                      std::span<const std::vector<SurfaceSample>> samples, std::size_t most_points);

struct Brightness {
  bool inside = false;       // of the photograph; otherwise all else is 0
  double value = 0;          // with the view's gain
  glm::dvec2 image{0.0};     // where the camera sees the point, pixels
  glm::dvec2 by_image{0.0};  // per pixel
  PoseOffset by_pose{};
};

// `camera` is camera_at(frame, offset); the pyramid's level is the nearest that there is.
[[nodiscard]] Brightness brightness_at(const ComparedView& view, const PoseFrame& frame, const PoseOffset& offset,
                                       const Camera& camera, double level, const glm::dvec3& position);
// Of the colour at an image position, pixels; inside only where it is within the photograph.
[[nodiscard]] Brightness brightness_in(const ComparedView& view, double level, const glm::dvec2& image);

// A factor f on the light is the factor f^kBrightnessPower on the brightness, but for what is nearly black.
inline constexpr double kBrightnessPower = 1 / 2.4;

// The value that most of them agree on: the M-estimate of Tukey's biweight, from the median on. `values` may be
// reordered and has at least one.
[[nodiscard]] double robust_mean(std::vector<double>& values, double noise);

}  // namespace lumatlas
