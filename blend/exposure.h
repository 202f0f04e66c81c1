// SPDX-License-Identifier: GPL-3.0-or-later
// The exposure that a picture is shown in: that of the photographs that were taken nearby.
//
// Each stored view has a gain that brings it to the model's one exposure (Snapshot::gains). A camera's automatic
// exposure varies by a stop and more, so in the model's exposure bright surfaces clip, and the picture looks like no
// photograph from there. In the exposure of each pixel's own views it would be a mosaic. So the whole picture has one
// factor, interpolated between the stored views by Shepard's method, per channel and so with the white balance:
//
//   E_o = exp(-sum_i w_i ln g_i / sum_i w_i)             g_i: gain of stored view i
//   w_i = 1 / (q_i + e)^2
//   q_i = (|c_o - c_i|^2 + |p_o - p_i|^2) / D^2          c: camera centre
//   p   = c + D times the viewing direction              about what the camera looks at
//
// D is the median over the stored views of their median depth, e a constant. Absent from the paper, which blends at
// the common exposure of its section 3.3 and shows that.
#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "atlas/snapshot.h"
#include "blend/blend_options.h"
#include "mesh/camera/camera.h"

namespace lumatlas {

// The part of a snapshot from which the exposure of any picture is found. Holds no photograph.
class NearbyExposure {
 public:
  NearbyExposure() = default;  // without views
  // Looks at the views' cameras, depths and gains alone. Throws std::invalid_argument unless each view slot has a gain
  // as Snapshot describes.
  explicit NearbyExposure(const Snapshot& snapshot) { follow(snapshot); }
  // Takes another snapshot instead, and looks at the depths only of views whose masks are new. Throws likewise, and
  // then changes nothing.
  void follow(const Snapshot& snapshot);

  // E_o, per channel R G B: linear light of the model times this is the picture's. Within the range of the inverse
  // gains; exactly 1 if all gains are 1 or there are no views. Continuous in the camera's pose: ln E_o changes by at
  // most the spread of the ln g_i times 15 per D that the camera moves and 10 per radian that it turns.
  [[nodiscard]] glm::dvec3 at(const Camera& camera) const;
  [[nodiscard]] double per_depth() const { return per_depth_; }  // 1 / D; 0 if no view sees a surface

 private:
  struct View {
    glm::dvec3 center;
    glm::dvec3 direction;
    glm::dvec3 log_gain;
  };
  // The median depth of a view, as long as it has that mask.
  struct Median {
    std::weak_ptr<const ViewMask> mask;
    std::optional<double> depth;  // none: the view sees no surface
  };
  void follow_depths(const Snapshot& snapshot);

  std::vector<View> views_;
  std::vector<Median> medians_;  // one per view slot
  float below_ = 0;              // depths from here on do not count in them
  double per_depth_ = 0;         // 1 / D; 0 if no view sees a surface, so that the directions alone decide
};

// The factor of a picture's linear light that the options ask for.
[[nodiscard]] glm::dvec3 picture_exposure(const NearbyExposure& nearby, const Camera& camera,
                                          const BlendOptions& options);

// Linear light from which on a channel of a photograph counts as clipped, the more the nearer it is to 1: sRGB 250.
// Shared with the shader.
inline constexpr double kClippedFrom = 0.955;

// Returns the factor from a photograph's linear colour to the model's exposure, for a picture that is shown in
// `exposure`: the photograph's gain, and where it is clipped at least what makes the picture white. A white sky stays
// white where the photograph was exposed longer than the picture.
[[nodiscard]] glm::dvec3 shown_gain(const glm::dvec3& gain, const glm::dvec3& color, const glm::dvec3& exposure);

}  // namespace lumatlas
