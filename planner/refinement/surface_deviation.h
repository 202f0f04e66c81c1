// SPDX-License-Identifier: GPL-3.0-or-later
// Measures the distance of the surface from what photographs show: the trust that each part of it deserves.
//
// The planner compares points of the surface in two views whose directions are a few degrees apart. It moves the patch
// around a point along the first view's ray until the second view shows the same image; the distance moved is the error
// of the surface there. Where no distance matches a textured patch (leaves, glass, fur), the error is at least the
// distance searched. A patch that reaches over an edge of the surface in one of the views is not compared. A point's
// error is the lower median over several pairs of views. The paper takes the surface as exact.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "atlas/snapshot.h"
#include "mesh/cancel_check.h"

namespace lumatlas {

struct DeviationOptions {
  std::uint32_t points = 12;       // compared per cell, >= 1
  std::uint32_t patch_radius = 5;  // pixels of the second photograph, [1, 32]; less below 1000 pixels of width
  double most_shift_px = 6;        // how far the patch is moved there, pixels, [1, 64]
  double least_angle_deg = 2;      // between the two directions; less tells too little of the distance, (0, 90)
  double most_angle_deg = 25;      // more shows the patch too differently, (least_angle_deg, 90)
  double least_correlation = 0.6;  // from which two patches show the same, (0, 1]
  double least_contrast = 4;       // standard deviation of a patch that has texture, of 255, > 0
  CancelCheck cancel_check;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const DeviationOptions& options);

struct SurfaceDeviation {
  // Standard deviation of the surface along a ray, scene units, one per cell. It is a lower bound where no distance
  // matches. A cell without measurement has the deviation of the nearest measured cells where at least a quarter of
  // all cells are measured, else 0. The far sphere has 0.
  std::vector<float> of_cell;
  std::vector<std::uint8_t> measured;  // one per cell: 1 if measured at its own points, else 0

  [[nodiscard]] bool any_measured() const { return std::find(measured.begin(), measured.end(), 1) != measured.end(); }
};

// Throws std::invalid_argument unless snapshot and options pass check().
[[nodiscard]] SurfaceDeviation surface_deviation(const Snapshot& snapshot, const DeviationOptions& options = {});

// Angle between picture and photograph, degrees, at which trust is told.
inline constexpr double kTrustAngle = 10;

// Returns the shift, in pixels of a picture with that focal length (pixels), of a point at that depth if it is off by
// `deviation` along the ray of a photograph kTrustAngle degrees aside. Deviation and depth are in scene units.
[[nodiscard]] double shift_px(double deviation, double focal_length, double depth);

}  // namespace lumatlas
