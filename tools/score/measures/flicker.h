// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how much a rendering flickers while the camera moves smoothly: see tools/score/README.md.
//
// The colour of one surface point X changes from frame t to the next, in the true pictures too where the surface is
// glossy. What it changes beyond that is the change of the error e = rendering less true picture, followed on X:
//
//   F = sqrt(mean over X and channels of (e_{t+1}(X) - e_t(X))^2)      8-bit sRGB levels
//
// An error that stays on the surface, blur for one, is no flicker; a reflection that should move and does not, is.
// e is smoothed by (1 4 6 4 1)/16 along rows and columns first: X falls between pixels in the next frame, and what
// interpolation takes from detail of a pixel's size would count as change.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

struct Flicker {
  double rms = 0;            // F over all pairs of neighbouring frames; NaN if no point was followed
  double worst = 0;          // F of the pair where it is largest; NaN likewise
  std::size_t followed = 0;  // points, over all pairs
};

// Takes the frames of a path one after another.
class FlickerMeter {
 public:
  // `visible` is what the camera sees at its own size, which the pictures have too (std::invalid_argument otherwise). A
  // point is followed if it is the middle of a pixel that lies, with all pixels within two of it, on one smooth surface
  // inside the lens's image (truth.valid). The four pixels around it in the next frame must do so too, and be within 1
  // % of its depth there.
  void add(const Camera& camera, const VisibilityBuffer& visible, const Photograph& rendering, const Photograph& truth);

  [[nodiscard]] Flicker flicker() const;

 private:
  struct Frame {
    Camera camera;
    std::vector<float> inverse_depth;  // 0 where the pixel is not followed
    std::vector<float> error[3];       // smoothed, per channel
  };
  void compare(const Frame& from, const Frame& to);

  std::optional<Frame> previous_;
  double squares_ = 0;
  double worst_square_ = -1;
  std::size_t followed_ = 0;
};

}  // namespace lumatlas
