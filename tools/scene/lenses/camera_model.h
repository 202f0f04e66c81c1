// SPDX-License-Identifier: GPL-3.0-or-later
// COLMAP's lens models, and Metashape's: from a direction in the camera frame to a point of the photograph.
// The frames are those of mesh/camera/camera.h; COLMAP's are the same.
//
// A model is a distortion d of the normalised image plane followed by focal lengths and principal point:
//
//   image = (fx, fy) * d(x / z, y / z) + (cx, cy)
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string_view>

namespace lumatlas {

// The values below kColmapModelCount are COLMAP's numbers for its models, which its binary files hold. No file holds
// the others.
enum class LensModel : std::int32_t {
  kSimplePinhole = 0,
  kPinhole = 1,
  kSimpleRadial = 2,
  kRadial = 3,
  kOpenCv = 4,
  kOpenCvFisheye = 5,
  kFullOpenCv = 6,
  kFov = 7,
  kSimpleRadialFisheye = 8,
  kRadialFisheye = 9,
  kThinPrismFisheye = 10,
  kRadTanThinPrismFisheye = 11,
  kSimpleDivision = 12,
  kDivision = 13,
  kSimpleFisheye = 14,
  kFisheye = 15,
  kEucm = 16,
  kEquirectangular = 17,
  kBrown = 18,         // Metashape's and RealityCapture's: radial terms up to r^8, and a skew
  kBrownFisheye = 19,  // the same of the angle to the axis
};
inline constexpr std::int32_t kColmapModelCount = 18;
inline constexpr std::int32_t kLensModelCount = 20;

// COLMAP's model of this number or name; none if COLMAP has no such model.
[[nodiscard]] std::optional<LensModel> lens_model(std::int32_t colmap_id);
[[nodiscard]] std::optional<LensModel> lens_model(std::string_view colmap_name);
[[nodiscard]] std::string_view name(LensModel model);             // COLMAP's name, such as "OPENCV_FISHEYE"
[[nodiscard]] std::size_t parameter_count(LensModel model);       // at most 16
[[nodiscard]] std::string_view parameter_names(LensModel model);  // in order, such as "f, cx, cy, k"

// A lens with its photograph's size.
struct CameraModel {
  LensModel model = LensModel::kPinhole;
  std::uint32_t width = 0;   // pixels
  std::uint32_t height = 0;  // pixels
  std::array<double, 16>
      parameters{};  // those of parameter_names(model), in that order; 0 from parameter_count(model) on

  [[nodiscard]] glm::dvec2 focal_length() const;     // pixels; (0, 0) for a panorama, which has none
  [[nodiscard]] glm::dvec2 principal_point() const;  // pixels; (0, 0) for a panorama

  friend bool operator==(const CameraModel&, const CameraModel&) = default;
};

// Throws std::invalid_argument naming the field, its value and the rule: sizes in [1, 65536], parameters finite, focal
// lengths positive, principal point within 1e6, omega of FOV in (-pi, pi), alpha of EUCM in [0, 1] and beta positive.
void check(const CameraModel& lens);

// Returns the lens for photographs that were scaled to this size in pixels, each axis by its own factor. Where the
// factors differ, a model with one focal length becomes the model with two that has the same distortion.
[[nodiscard]] CameraModel scaled(const CameraModel& lens, std::uint32_t width, std::uint32_t height);

// This is false for a full panorama: no plane holds what it sees.
[[nodiscard]] bool can_be_pinhole(LensModel model);

// This is false if the lens is a pinhole already, by its model or because every coefficient of its distortion is 0.
[[nodiscard]] bool is_distorted(const CameraModel& lens);

// Returns the pixel at which the lens images a direction (of any length) of the camera frame. None behind the camera (z
// <= 0) and where the model has no image of it. Beyond reach() the answer may lie on the wrong side of a fold. Throws
// std::invalid_argument for a panorama.
[[nodiscard]] std::optional<glm::dvec2> image_from_cam(const CameraModel& lens, const glm::dvec3& cam);

// The largest radius in the plane z = 1, up to `limit`, inside which the lens images different directions at different
// points. A distortion is a polynomial fitted to the photograph; outside of it, many turn back and image the far field
// onto the middle a second time. A place that the lens shrinks more than 20 times counts as the start of a fold.
[[nodiscard]] double reach(const CameraModel& lens, double limit);

}  // namespace lumatlas
