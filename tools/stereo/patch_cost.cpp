// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/patch_cost.h"

#include <algorithm>
#include <cmath>

// The loops below are compiled twice, and the machine's instructions decide which of them run. Both give the same
// numbers: every lane's sums are added in the same order, and nothing is contracted (see CMakeLists.txt).
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define LUMATLAS_SIMD_CLONES __attribute__((target_clones("arch=haswell", "default")))
#else
#define LUMATLAS_SIMD_CLONES
#endif

namespace lumatlas {
namespace {

constexpr float kVarianceFloor = 4;  // luma squared: of noise, below which nothing is told apart
constexpr double kSigmaLuma = 25;    // sigma of the bilateral weights
constexpr double kSigmaPixels = 5;
constexpr std::size_t kLanes = 8;
constexpr std::size_t kRounds = kPatchSamples / kLanes;

struct Offsets {
  alignas(32) std::array<float, kPatchSamples> x{};
  alignas(32) std::array<float, kPatchSamples> y{};
  std::array<double, kPatchSamples> weight{};
};

const Offsets& offsets() {
  static const Offsets all = [] {
    Offsets result;
    std::size_t i = 0;
    for (int y = -5; y <= 5; y += 2) {
      for (int x = -5; x <= 5; x += 2) {
        if (std::abs(x) == 5 && std::abs(y) == 5) continue;
        result.x[i] = static_cast<float>(x);
        result.y[i] = static_cast<float>(y);
        result.weight[i++] = std::exp(-(x * x + y * y) / (2 * kSigmaPixels * kSigmaPixels));
      }
    }
    return result;
  }();
  return all;
}

const std::array<float, 256>& luma_weights() {
  static const std::array<float, 256> weights = [] {
    std::array<float, 256> result{};
    for (std::size_t i = 0; i < result.size(); ++i) {
      const double difference = static_cast<double>(i);
      result[i] = static_cast<float>(std::exp(-difference * difference / (2 * kSigmaLuma * kSigmaLuma)));
    }
    return result;
  }();
  return weights;
}

// The homography of a plane, from offsets of the pixel's centre.
struct Warp {
  float x0, y0, z0;  // the centre's
  float x_u, y_u, z_u;
  float x_v, y_v, z_v;
  float last_x, last_y;
};

// Luma at the samples' places, which are held inside of the picture.
LUMATLAS_SIMD_CLONES void sample(const Warp& warp, const float* offset_x, const float* offset_y,
                                 const std::uint32_t* quads, std::int32_t width, float* luma) {
  for (std::size_t i = 0; i < kPatchSamples; ++i) {
    const float inverse = 1.0F / (warp.z0 + offset_x[i] * warp.z_u + offset_y[i] * warp.z_v);
    float x = (warp.x0 + offset_x[i] * warp.x_u + offset_y[i] * warp.x_v) * inverse - 0.5F;
    float y = (warp.y0 + offset_x[i] * warp.y_u + offset_y[i] * warp.y_v) * inverse - 0.5F;
    x = x > 0.0F ? x : 0.0F;
    y = y > 0.0F ? y : 0.0F;
    x = x < warp.last_x ? x : warp.last_x;
    y = y < warp.last_y ? y : warp.last_y;
    const auto column = static_cast<std::int32_t>(x);
    const auto row = static_cast<std::int32_t>(y);
    const float right = x - static_cast<float>(column);
    const float down = y - static_cast<float>(row);
    const std::uint32_t quad = quads[row * width + column];
    const auto a = static_cast<float>(static_cast<std::int32_t>(quad & 0xFFU));
    const auto b = static_cast<float>(static_cast<std::int32_t>((quad >> 8U) & 0xFFU));
    const auto c = static_cast<float>(static_cast<std::int32_t>((quad >> 16U) & 0xFFU));
    const auto d = static_cast<float>(static_cast<std::int32_t>(quad >> 24U));
    const float above = a + right * (b - a);
    const float below = c + right * (d - c);
    luma[i] = above + down * (below - above);
  }
}

// Adds luma, luma squared, and luma with the reference's, by their weights.
LUMATLAS_SIMD_CLONES void add_moments(const float* weight, const float* weighted, const float* luma, float* mean,
                                      float* square, float* product) {
  for (std::size_t round = 0; round < kRounds; ++round) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const float value = luma[round * kLanes + lane];
      const float share = weight[round * kLanes + lane] * value;
      mean[lane] += share;
      square[lane] += share * value;
      product[lane] += weighted[round * kLanes + lane] * value;
    }
  }
}

float sum(const std::array<float, kLanes>& lanes) {
  return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

}  // namespace

ReferencePatch reference_patch(const LumaImage& image, glm::ivec2 pixel) {
  const Offsets& offset = offsets();
  const std::array<float, 256>& by_luma = luma_weights();
  const auto width = static_cast<int>(image.camera.width), height = static_cast<int>(image.camera.height);
  const int centre =
      image.luma(static_cast<std::size_t>(pixel.y) * image.camera.width + static_cast<std::size_t>(pixel.x));
  std::array<float, kPatchSamples> luma{};
  ReferencePatch patch;
  float weights = 0, mean = 0;
  for (std::size_t i = 0; i < kPatchSamples; ++i) {
    const int x = pixel.x + static_cast<int>(offset.x[i]), y = pixel.y + static_cast<int>(offset.y[i]);
    patch.weight[i] = 0;
    if (x < 0 || y < 0 || x >= width || y >= height) continue;
    const std::size_t at = static_cast<std::size_t>(y) * image.camera.width + static_cast<std::size_t>(x);
    if (!image.is_valid(at)) continue;
    const int value = image.luma(at);
    luma[i] = static_cast<float>(value);
    patch.weight[i] =
        static_cast<float>(offset.weight[i]) * by_luma[static_cast<std::size_t>(std::abs(value - centre))];
    weights += patch.weight[i];
    mean += patch.weight[i] * luma[i];
  }
  const float scale = weights > 0 ? 1 / weights : 0;
  mean *= scale;
  for (std::size_t i = 0; i < kPatchSamples; ++i) {
    patch.weight[i] *= scale;
    const float difference = luma[i] - mean;
    patch.weighted_luma[i] = patch.weight[i] * difference;
    patch.variance += patch.weighted_luma[i] * difference;
  }
  return patch;
}

PixelTransfer pixel_transfer(const Camera& from, const Camera& to) {
  const glm::dmat3 rotation = to.cam_from_world_rotation * glm::transpose(from.cam_from_world_rotation);
  const glm::dvec3 translation = to.cam_from_world_translation - rotation * from.cam_from_world_translation;
  const glm::dmat3 to_pixels(to.fx, 0, 0, 0, to.fy, 0, to.cx, to.cy, 1);
  const glm::dmat3 from_pixels(1 / from.fx, 0, 0, 0, 1 / from.fy, 0, -from.cx / from.fx, -from.cy / from.fy, 1);
  return {glm::mat3(to_pixels * rotation * from_pixels), glm::vec3(to_pixels * translation),
          static_cast<float>(to.width - 1), static_cast<float>(to.height - 1)};
}

float patch_cost(const ReferencePatch& patch, glm::ivec2 pixel, const SlantedPlane& plane,
                 const PixelTransfer& transfer, const LumaImage& other) {
  const glm::vec3 centre = transfer.homogeneous(glm::vec2(pixel) + 0.5F, plane.w);
  const glm::vec3 right = transfer.a[0] + plane.w_u * transfer.epipole;
  const glm::vec3 down = transfer.a[1] + plane.w_v * transfer.epipole;
  // The whole patch must lie before the camera: of its corners' distances none may change its sign.
  const float reach = 5 * (std::abs(right.z) + std::abs(down.z));
  if (!(centre.z > reach) || !(centre.z > 0)) return kLargestPatchCost;
  const float x = centre.x / centre.z, y = centre.y / centre.z;
  if (!(x >= 0 && y >= 0 && x < transfer.last_x + 1 && y < transfer.last_y + 1)) return kLargestPatchCost;
  const std::size_t at = static_cast<std::size_t>(y) * other.camera.width + static_cast<std::size_t>(x);
  if (!other.is_valid(at)) return kLargestPatchCost;

  const Offsets& offset = offsets();
  alignas(32) std::array<float, kPatchSamples> luma;
  sample({centre.x, centre.y, centre.z, right.x, right.y, right.z, down.x, down.y, down.z, transfer.last_x,
          transfer.last_y},
         offset.x.data(), offset.y.data(), other.quads.data(), static_cast<std::int32_t>(other.camera.width),
         luma.data());
  alignas(32) std::array<float, kLanes> means{}, squares{}, products{};
  add_moments(patch.weight.data(), patch.weighted_luma.data(), luma.data(), means.data(), squares.data(),
              products.data());
  const float mean = sum(means);
  const float variance = sum(squares) - mean * mean;
  // The reference's lumas are less their mean, so that the product needs none of the other's.
  return 1 - sum(products) /
                 std::sqrt((patch.variance + kVarianceFloor) * ((variance > 0 ? variance : 0) + kVarianceFloor));
}

}  // namespace lumatlas
