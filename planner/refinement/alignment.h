// SPDX-License-Identifier: GPL-3.0-or-later
// Direct photometric alignment: moves a camera, and scales its exposure, until its photograph agrees with given colours
// of surface points. Erat et al. 2019, section 3.3:
//
//   J(f) = sum_j m(E_f e_f(pr(X_j, f)) - c_j)         m: Tukey's biweight, c_j: linear colour of X_j
//
// Departures from the print: Levenberg-Marquardt over pose and exposure together, coarse to fine, instead of optical
// flow alternating with exposure. The alternation converges to the same minimum, but slower. A difference in linear
// light counts as much as it changes the sRGB value, as in the score and in the eye. A weak pull towards the given pose
// keeps motions that the photographs leave open (sliding along a plain wall) at 0.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "mesh/camera/camera.h"
#include "planner/refinement/pyramid.h"

namespace lumatlas {

// Points of the surface and their colours, linear light, as seen at each resolution: colors[level][point].
struct AlignmentTargets {
  std::vector<glm::dvec3> positions;
  // Level 0 first, as many levels as the photograph's pyramid has; those that are not needed may be empty.
  std::vector<std::vector<glm::vec3>> colors;
};

struct AlignmentOptions {
  bool pose = true;
  bool exposure = true;
  bool white_balance = false;  // a gain for each channel instead of one for all; needs exposure
  double max_move = 0.06;      // a pose is not accepted if the points' median displacement in the image is above this
                               // share of its longer side, > 0
  double least_improvement = 0.05;  // nor if it lowers the residual by less than this share, [0, 1)
  // A search that starts at an accepted pose other than the given one keeps that pose, unless the points' median
  // displacement in the image is at least this many pixels, finite and >= 0. Less cannot be seen, and noise never ends.
  double least_move_px = 0.1;
  double prior = 4;                   // strength of the pull towards the given pose, >= 0
  std::uint32_t levels = 16;          // levels of the pyramid at most, the finest ones, >= 1
  std::uint32_t max_iterations = 10;  // per level, >= 1
  bool correlation = true;            // compute Alignment::correlation
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const AlignmentOptions& options);

// Returns whether align() looks at the targets' colours at this level of the pyramid.
[[nodiscard]] bool needs_level(const AlignmentOptions& options, const Pyramid& photograph, std::uint32_t level);

// Fewer points than this say nothing about a pose.
inline constexpr std::size_t kFewestAlignmentPoints = 60;

struct Alignment {
  Camera camera;  // refined, or the given one where corrected is false
  glm::dvec3 gain{1.0};
  bool corrected = false;  // `camera` is not the given one: a better pose was found within the bounds
  bool moved = false;      // `camera` is not the one that the search started from
  double moved_px = 0;     // median displacement of the points in the image, of `camera` against the given pose
  // Root of the mean robust squared difference at the points, in sRGB values of [0, 1]: of the given pose and gain; of
  // the given pose with the best gain; of the pose that the search started from with the best gain; final.
  double residual_given = 0;
  double residual_exposed = 0;
  double residual_start = 0;
  double residual = 0;
  // The share of residual_exposed by which the pose that the search found has less, accepted or not. Below 0 if it has
  // more, 0 without a search.
  double found_improvement = 0;
  // Correlation of photograph and colours in the parts of the picture where it is highest: see alignment.cpp. [-1, 1].
  // None if no part has points and texture enough in both to tell whether the pose is right, or if it was not asked
  // for.
  std::optional<double> correlation;
};

// The weak pull towards the given pose: what residuals, in standard deviations, of six pose parameters (a rotation
// vector and a translation in median depths of the points) are multiples of.
[[nodiscard]] double pose_pull(const AlignmentOptions& options, const Camera& camera, std::size_t points);

// The pose starts at `start`, the exposure at `gain`; pull and bound are towards and around the pose `given`. With
// fewer than kFewestAlignmentPoints points the camera is the given one and the gain `gain`.
//
// Throws std::invalid_argument unless the options and both cameras pass check(), the cameras have the photograph's size
// and the same intrinsics, the gain is finite and positive, and the targets have a colour for each position at each
// level of the pyramid that is needed.
[[nodiscard]] Alignment align(const Camera& given, const Camera& start, const glm::dvec3& gain,
                              const Pyramid& photograph, const AlignmentTargets& targets,
                              const AlignmentOptions& options);

}  // namespace lumatlas
