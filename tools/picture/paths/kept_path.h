// SPDX-License-Identifier: GPL-3.0-or-later
// Paths that keep to what was photographed, so that they show a scene rather than where it ends.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "tools/picture/paths/camera_path.h"

namespace lumatlas {

// A surface point is photographed, as seen from a camera, if a stored view that its cell refers to sees it from a
// direction at most this far off, and from at most this many times the distance. A point that was only seen from
// behind, or from so far that the picture is a blur, does not count.
inline constexpr double kPhotographedCosine = 0.5;  // 60 degrees
inline constexpr double kPhotographedEnlargement = 2.5;
// A picture is covered if its photographed share is more than this part of the median share of the stored cameras.
inline constexpr double kCoveredShare = 0.6;

// Returns the share of the picture from there that shows photographed surface, in [0, 1].
using PhotographedShare = std::function<double(const Vantage&)>;

struct KeptPath {
  std::vector<Vantage> vantages;
  double covered_before = 0;  // share of the frames that are covered, as the path was given
  double covered = 0;         // the path's present share
  std::size_t moved = 0;      // frames that are not where the path was given
  double arc_deg = 360;       // an orbit's angle; less than 360: it swings to and fro
};

// A frame is covered if its share is at least kCoveredShare of the median share of what the `stored` cameras see
// themselves, with the path's field of view. Frames that are not are pulled towards the cameras nearest to them, as far
// as they must and no further; their neighbours go along, so that the path stays smooth. `up`, unit, stays upwards in
// the pictures. `depth` > 0: as in camera_tours.h, by which moving is weighed against turning. `closed`: the last frame
// is followed by the first. Throws std::invalid_argument without stored cameras.
[[nodiscard]] KeptPath keep_to_photographs(const std::vector<Vantage>& path, std::span<const Camera> stored,
                                           const glm::dvec3& up, double depth, bool closed,
                                           const PhotographedShare& share);

// An orbit (camera_tours.h) of as many frames. Where the whole circle is covered it is that circle; else it swings to
// and fro over the longest arc that is, slowing down at its ends, and closes; where no part is, the circle's frames are
// pulled as above. Throws std::invalid_argument without stored cameras.
[[nodiscard]] KeptPath kept_orbit(std::span<const Camera> stored, double depth, std::size_t frames, double fov_deg,
                                  const PhotographedShare& share);

}  // namespace lumatlas
