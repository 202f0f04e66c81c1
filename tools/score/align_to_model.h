// SPDX-License-Identifier: GPL-3.0-or-later
// The pose and exposure of a photograph that was held out, refined against what a model shows: its given pose is as
// wrong as any other, and a score at that pose would measure the pose.
//
// A picture's points move with the camera as surface, depth and image gradients say (planner/refinement/alignment.h),
// so that one picture, which is there already, gives a whole search. What that leaves out, how the views that are
// blended change with the pose, changes slowly: only a pose that was found far away is looked at once more from there.
#pragma once

#include <functional>
#include <optional>

#include "atlas/images/photograph.h"
#include "mesh/visibility/visibility.h"
#include "planner/refinement/pyramid.h"

namespace lumatlas {

// The picture of a model from one pose, and the visible part of its surface, at the same size.
struct Seen {
  Photograph picture;
  VisibilityBuffer visible;
};

// Callbacks that draw a model. Both return a picture of the camera's size.
struct ModelPictures {
  std::function<Photograph(const Camera&)> draw;    // draws as scoring does
  std::function<Photograph(const Camera&)> sketch;  // in less time
  const Visibility& visibility;
};

// A refined pose, and what is seen from there.
struct AlignedView {
  Camera camera;
  Seen seen;
};

// Farther than this share of the longer side, in the median of the points in the image, a pose is far away.
inline constexpr double kFarAlignment = 0.02;

// Refines the pose of a held-out photograph against the model, which looks as in `at_given` from the given pose.
// Returns nothing if picture and photograph agree better at no other pose, or only at one less than a tenth of a pixel
// away. Draws one picture, and one sketch if the pose that is found is far away. `photograph` is taken by the camera
// (std::invalid_argument unless the sizes are the same). Throws Interrupted once the user has asked the program to
// stop.
[[nodiscard]] std::optional<AlignedView> align_to_model(const ModelPictures& model, const Camera& given,
                                                        const Seen& at_given, const Pyramid& photograph);

}  // namespace lumatlas
