// SPDX-License-Identifier: GPL-3.0-or-later
// How far the surface is from what the photographs show: the trust that each part of it deserves.
//
// A point of the surface is compared in two photographs that see it from directions a few degrees apart. The patch of
// surface around it, as the first photograph shows it, is moved along that photograph's ray until the second shows the
// same; how far it moves is how far the surface is off there. A part with texture that shows the same nowhere (leaves,
// glass, fur) is off by at least the distance that was searched. Of several such pairs of photographs the lower median
// counts. The paper takes the surface as exact.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "atlas/snapshot.h"
#include "planner/interruption.h"

namespace lumatlas {

struct DeviationOptions {
  std::uint32_t points = 12;       // compared per cell, >= 1
  std::uint32_t patch_radius = 5;  // of the second photograph's pixels, [1, 32]
  double most_shift_px = 6;        // how far the patch is moved there, pixels, [1, 64]
  double least_angle_deg = 2;      // between the two directions; less tells too little of the distance, (0, 90)
  double most_angle_deg = 25;      // more shows the patch too differently, (least_angle_deg, 90)
  double least_correlation = 0.6;  // from which two patches show the same, (0, 1]
  double least_contrast = 4;       // standard deviation of a patch that has texture, of 255, > 0
  InterruptionPoint interruption_point;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const DeviationOptions& options);

struct SurfaceDeviation {
  // Standard deviation of the surface along a ray, scene units, by cell of the snapshot's surface; of cells that agree
  // nowhere a lower bound. A cell that no two photographs show with texture has that of the nearest cells that have
  // one; 0 for the far sphere, and where nothing was measured at all.
  std::vector<float> of_cell;
  std::vector<std::uint8_t> measured;  // by cell, 1: from its own points

  [[nodiscard]] bool any_measured() const { return std::find(measured.begin(), measured.end(), 1) != measured.end(); }
};

// Throws std::invalid_argument unless snapshot and options pass check().
[[nodiscard]] SurfaceDeviation surface_deviation(const Snapshot& snapshot, const DeviationOptions& options = {});

// By how many pixels of a picture with that focal length, in pixels, a point at that depth shifts by the deviation when
// the camera stands kTrustAngle degrees beside the photograph.
inline constexpr double kTrustAngle = 10;
[[nodiscard]] double shift_px(double deviation, double focal_length, double depth);

}  // namespace lumatlas
