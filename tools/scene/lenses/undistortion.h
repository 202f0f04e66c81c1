// SPDX-License-Identifier: GPL-3.0-or-later
// From the photograph that a lens took to the one that a pinhole camera at the same place would have taken.
#pragma once

#include "atlas/images/photograph.h"
#include "mesh/camera/camera.h"
#include "mesh/camera/lens_correction.h"
#include "mesh/camera/shutter_motion.h"
#include "tools/scene/lenses/camera_model.h"

namespace lumatlas {

// The most that pinhole_view() magnifies to get rid of the border. A view loses up to a tenth of its field along each
// axis to it; more would cost too much, since the border itself costs only its own pixels.
inline constexpr double kLargestZoom = 1.1;

// Returns the pinhole camera, of identity pose, that photographs of this lens are undistorted to. It has the same size
// and principal point. Its focal lengths are the lens's times one factor: the least in [1, kLargestZoom] for which
// every pixel of the view lies inside the photograph. If there is none, the factor is 1, which keeps the whole field of
// view and a border. A lens without distortion keeps its focal lengths exactly. Throws std::invalid_argument as
// check(lens) does, for a panorama, and for a lens that sees nothing of the view.
[[nodiscard]] Camera pinhole_view(const CameraModel& lens);

// `photograph`, of the lens's size, resampled bilinearly to `view`, which is pinhole_view(lens) with any pose. Pixels
// that the lens did not see, or sees only beyond a fold of its distortion, are black with valid = 0; `valid` is empty
// if there are none. The mask of the photograph itself is honoured. Without distortion the photograph comes back as it
// is. `correction` says what is wrong with a picture that is undistorted by the lens alone, and `motion` how the camera
// moved while its shutter read the photograph, of points at the depth 1: all are undone at once, so that nothing is
// resampled twice. Throws std::invalid_argument if the photograph or the view has another size than the lens, or if the
// correction or the motion does not pass check().
[[nodiscard]] Photograph undistort(Photograph photograph, const CameraModel& lens, const Camera& view,
                                   const LensCorrection& correction = {}, const ShutterMotion& motion = {});

}  // namespace lumatlas
