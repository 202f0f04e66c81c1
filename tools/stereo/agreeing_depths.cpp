// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/agreeing_depths.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "tools/stereo/patch_cost.h"

namespace lumatlas {
namespace {

// Standard deviation of a correlation's maximum, pixels of the photograph that shows the pixel moving fastest.
constexpr double kMatchingPx = 0.3;

class Agreement {
 public:
  Agreement(const PosedPlanes& reference, std::span<const PosedPlanes> others, const AgreementOptions& options)
      : reference_(reference), others_(others), options_(options) {
    for (const PosedPlanes& other : others) {
      there_.push_back(pixel_transfer(reference.camera, other.camera));
      back_.push_back(pixel_transfer(other.camera, reference.camera));
    }
  }

  void find(std::uint32_t x, std::uint32_t y, StereoDepth& result) const {
    const std::size_t at = std::size_t{y} * reference_.camera.width + x;
    const SlantedPlane& plane = reference_.planes->planes[at];
    if (!(plane.w > 0) || reference_.planes->costs[at] > options_.most_cost) return;
    const glm::vec2 pixel(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
    const double own = 1 / static_cast<double>(plane.w);
    double sum = own, squares = 0, fastest = 0;
    std::size_t agreeing = 0, asked = 0;
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < others_.size(); ++i) {
      asked += is_in_view(i, pixel, plane.w) ? 1 : 0;
      const std::optional<double> depth = depth_by(i, pixel, plane.w);
      if (!depth || std::abs(*depth - own) > options_.most_difference * own) continue;
      ++agreeing;
      bits |= 1U << i;
      sum += *depth;
      squares += (*depth - own) * (*depth - own);
      fastest = std::max(fastest, pixels_per_inverse_depth(there_[i], pixel, plane.w));
    }
    if (agreeing < std::min(options_.least_views, others_.size()) || !(fastest > 0)) return;
    const double count = 1 + static_cast<double>(agreeing);
    const double depth = sum / count;
    const double matched = kMatchingPx / fastest * depth * depth;
    result.depth[at] = static_cast<float>(depth);
    // If most of the views that should see the same do not, the depth on which the rest agree is less sure than they
    // say.
    const double doubt = static_cast<double>(asked) / static_cast<double>(agreeing);
    result.deviation[at] = static_cast<float>(doubt * std::sqrt((matched * matched + squares / count) / count));
    result.agreeing[at] = bits;
  }

 private:
  [[nodiscard]] bool is_in_view(std::size_t other, glm::vec2 pixel, float w) const {
    const glm::vec3 seen = there_[other].homogeneous(pixel, w);
    const glm::vec2 at = glm::vec2(seen) / seen.z;
    return seen.z > 0 && at.x >= 0 && at.y >= 0 && at.x < static_cast<float>(others_[other].camera.width) &&
           at.y < static_cast<float>(others_[other].camera.height);
  }

  static double pixels_per_inverse_depth(const PixelTransfer& there, glm::vec2 pixel, float w) {
    const glm::vec3 at = there.homogeneous(pixel, w);
    const glm::vec2 place = glm::vec2(at) / at.z;
    return glm::length(glm::vec2(there.epipole) - place * there.epipole.z) / at.z;
  }

  // The depth in the reference of what the other's plane shows where the pixel is seen; none: it does not come back.
  [[nodiscard]] std::optional<double> depth_by(std::size_t other, glm::vec2 pixel, float w) const {
    const PlaneMap& planes = *others_[other].planes;
    if (!(way_back_px(pixel, w, there_[other], back_[other], planes) <= options_.most_way_px)) return std::nullopt;
    const glm::vec3 seen = there_[other].homogeneous(pixel, w);
    const glm::vec2 at = glm::vec2(seen) / seen.z;
    const glm::vec2 whole = glm::floor(at);
    const SlantedPlane& plane =
        planes.planes[static_cast<std::size_t>(whole.y) * planes.width + static_cast<std::size_t>(whole.x)];
    const float other_w = plane.moved(at.x - whole.x - 0.5F, at.y - whole.y - 0.5F).w;
    // homogeneous() is w times the point in the camera's frame, in its last coordinate.
    const glm::vec3 returned = back_[other].homogeneous(at, other_w);
    return static_cast<double>(returned.z) / other_w;
  }

  const PosedPlanes& reference_;
  std::span<const PosedPlanes> others_;
  const AgreementOptions& options_;
  std::vector<PixelTransfer> there_, back_;
};

}  // namespace

StereoDepth agreeing_depths(const PosedPlanes& reference, std::span<const PosedPlanes> others,
                            const AgreementOptions& options) {
  const Camera& camera = reference.camera;
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  StereoDepth result{camera, std::vector<float>(pixels), std::vector<float>(pixels),
                     std::vector<std::uint32_t>(pixels)};
  const Agreement agreement(reference, others, options);
  tbb::parallel_for(std::uint32_t{0}, camera.height, [&](std::uint32_t y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) agreement.find(x, y, result);
  });
  return result;
}

}  // namespace lumatlas
