// SPDX-License-Identifier: GPL-3.0-or-later
// Rates how well a small plane in front of one photograph explains what another one shows: the hot loop of stereo.
//
// The plane is held as inverse depth w, which is affine in the image: w(x + dx, y + dy) = w + w_u dx + w_v dy. A
// pixel's patch moves to the other photograph by the homography that the plane makes, H = A + a (w_u, w_v, w)^T with
// A = K' R K^-1 and a = K' t. What is compared is normalized cross-correlation with bilateral weights: samples of the
// centre's brightness and near to it count most, so that a patch may lie across an edge of depth (Schoenberger et al.,
// "Pixelwise view selection for unstructured multi-view stereo", 2016, section 4.1).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "tools/stereo/luma_image.h"

namespace lumatlas {

// A surface near a pixel's centre as seen from its photograph.
struct SlantedPlane {
  float w = 0;             // 1 / depth, 1 / scene units
  float w_u = 0, w_v = 0;  // its growth a pixel to the right, and down

  [[nodiscard]] SlantedPlane moved(float right, float down) const { return {w + w_u * right + w_v * down, w_u, w_v}; }
};

inline constexpr std::size_t kPatchSamples = 32;  // every second pixel of 11 x 11, without the corners
inline constexpr float kLargestPatchCost = 2;     // 1 - correlation, [0, 2]

// The samples around a pixel of the reference photograph.
struct ReferencePatch {
  alignas(32) std::array<float, kPatchSamples> weight;         // add up to 1; 0: not valid
  alignas(32) std::array<float, kPatchSamples> weighted_luma;  // weight times luma less its mean
  float variance = 0;                                          // the weighted luma's
};
// `pixel` is a valid one.
[[nodiscard]] ReferencePatch reference_patch(const LumaImage& image, glm::ivec2 pixel);

// Maps pixels of a photograph to another one of the same scene.
struct PixelTransfer {
  glm::mat3 a;           // A: of what is infinitely far
  glm::vec3 epipole;     // a: what an inverse depth of 1 adds
  float last_x, last_y;  // the other photograph's size in pixels, less 1

  // Returns the homogeneous pixel that shows the pixel's plane; z <= 0: behind the camera.
  [[nodiscard]] glm::vec3 homogeneous(glm::vec2 pixel, float w) const {
    return a * glm::vec3(pixel, 1.0F) + w * epipole;
  }
};
[[nodiscard]] PixelTransfer pixel_transfer(const Camera& from, const Camera& to);

// Returns 1 - the weighted correlation of the patch with `other`, warped by the plane, or kLargestPatchCost if the
// pixel is outside of `other` or behind its camera. Textureless patches cost about 1. Every machine gives the same
// number.
[[nodiscard]] float patch_cost(const ReferencePatch& patch, glm::ivec2 pixel, const SlantedPlane& plane,
                               const PixelTransfer& transfer, const LumaImage& other);

}  // namespace lumatlas
