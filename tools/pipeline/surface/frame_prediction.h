// SPDX-License-Identifier: GPL-3.0-or-later
// Predicts small photographs without themselves, to measure what a surface is good for.
//
// Where a photograph sees a surface, its prediction is the mean colour of the same points in the other photographs that
// are nearest in direction; elsewhere it is the fill that pictures have there (tools/frame/background.h).
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "mesh/visibility/visibility.h"
#include "tools/pipeline/surface/far_background.h"

namespace lumatlas {

// A small photograph and its visibility buffer of a mesh. Refers to the photograph.
struct FrameLook {
  const SmallPhotograph& photograph;
  glm::dvec3 center;
  VisibilityBuffer visible;

  FrameLook(const SmallPhotograph& small, VisibilityBuffer buffer);
  FrameLook(const SmallPhotograph& small, const Visibility& mesh);

  [[nodiscard]] bool sees_surface(std::size_t pixel) const { return visible.face[pixel] != FaceId::none; }
  [[nodiscard]] glm::dvec3 point_at(std::size_t pixel) const;  // where a pixel sees the surface
  // Returns the colour of a point of the surface; null if the photograph does not show it.
  [[nodiscard]] const glm::vec3* color_of(const glm::dvec3& point) const;
};

// Throws Interrupted soon after a signal.
[[nodiscard]] std::vector<FrameLook> frame_looks_at(const std::vector<SmallPhotograph>& photographs,
                                                    const Visibility& mesh);

// Returns the mean of the squared differences of the three channels, in squared levels.
[[nodiscard]] double squared_error(const glm::vec3& a, const glm::vec3& b);

// Returns the colour of a pixel of looks[own] that sees the surface, as the other photographs predict it; none if they
// do not show it.
[[nodiscard]] std::optional<glm::vec3> predicted_color(const std::vector<FrameLook>& looks, std::size_t own,
                                                       std::size_t pixel);

// The error with which the other photographs predict the surface that one sees.
struct SurfaceError {
  double mean = std::numeric_limits<double>::quiet_NaN();  // squared error; NaN: no other photograph shows the same
  float gain = 1;  // brightness of the photograph, as a multiple of that of its prediction
};

// The errors of one photograph's pixels.
struct FrameError {
  SurfaceError surface;
  double shown = 0;                  // number of pixels that see a surface or the far sphere
  std::vector<std::size_t> lacking;  // the pixels that see neither
  std::vector<double> filled;        // squared error of the fill at each of these

  [[nodiscard]] double shown_sum() const { return surface.mean * shown; }
  [[nodiscard]] double filled_sum() const { return std::accumulate(filled.begin(), filled.end(), 0.0); }
};

// Returns the errors of each photograph; one that cannot be compared with others gets the mean surface error of those
// that can. `far`: null if there is no far sphere. None: no two photographs show the same point. Throws Interrupted
// soon after a signal.
[[nodiscard]] std::optional<std::vector<FrameError>> frame_errors(const std::vector<FrameLook>& looks,
                                                                  const Visibility* far);

}  // namespace lumatlas
