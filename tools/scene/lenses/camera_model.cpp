// SPDX-License-Identifier: GPL-3.0-or-later
// Formulas: COLMAP's documentation of its camera models, and
//   Weng et al., "Camera Calibration with Distortion Models and Accuracy Evaluation", 1992 (radial, tangential, prism)
//   Devernay, Faugeras, "Straight lines have to be straight", 2001 (FOV)
//   Fitzgibbon, "Simultaneous linear estimation of multiple view geometry and lens distortion", 2001 (division)
//   Khomutenko et al., "An Enhanced Unified Camera Model", 2016 (EUCM)
//   Agisoft Metashape user manual, appendix "Camera models", of versions 1.2 to 2 (BROWN)
#include "tools/scene/lenses/camera_model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace lumatlas {
namespace {

// From the plane z = 1 to the distorted plane; `k` are the coefficients after focal lengths and principal point.
// The result is not a number where the model has no image.
using Distortion = glm::dvec2 (*)(const double* k, const glm::dvec2& p);

double squared_length(const glm::dvec2& p) {
  return glm::dot(p, p);
}

// 1 + k0 t + k1 t^2 + ...
template <std::size_t N>
double series(const std::array<double, N>& k, double t) {
  double sum = 0;
  for (std::size_t i = N; i-- > 0;) {
    sum = (sum + k[i]) * t;
  }
  return 1 + sum;
}

glm::dvec2 tangential(double p1, double p2, const glm::dvec2& p) {
  const double r2 = squared_length(p);
  const double xy = p.x * p.y;
  return {2 * p1 * xy + p2 * (r2 + 2 * p.x * p.x), 2 * p2 * xy + p1 * (r2 + 2 * p.y * p.y)};
}

// atan(t) / t, continued by 1 at 0.
double atan_ratio(double t) {
  return std::abs(t) < 1e-4 ? 1 - t * t / 3 : std::atan(t) / t;
}

// The equidistant projection: the angle to the axis becomes the radius.
glm::dvec2 equidistant(const glm::dvec2& p) {
  return p * atan_ratio(glm::length(p));
}

glm::dvec2 identity(const double*, const glm::dvec2& p) {
  return p;
}

glm::dvec2 simple_radial(const double* k, const glm::dvec2& p) {
  return p * (1 + k[0] * squared_length(p));
}

glm::dvec2 radial(const double* k, const glm::dvec2& p) {
  return p * series<2>({k[0], k[1]}, squared_length(p));
}

glm::dvec2 opencv(const double* k, const glm::dvec2& p) {
  return radial(k, p) + tangential(k[2], k[3], p);
}

glm::dvec2 full_opencv(const double* k, const glm::dvec2& p) {
  const double r2 = squared_length(p);
  const double ratio = series<3>({k[0], k[1], k[4]}, r2) / series<3>({k[5], k[6], k[7]}, r2);
  return p * ratio + tangential(k[2], k[3], p);
}

// atan(2 r tan(omega / 2)) / omega. COLMAP replaces it by a series for small omega and for small r; this is the limit
// of the formula itself.
glm::dvec2 fov(const double* k, const glm::dvec2& p) {
  const double omega = k[0];
  const double slope = std::abs(omega) < 1e-4 ? 1 + omega * omega / 12 : 2 * std::tan(omega / 2) / omega;
  return p * slope * atan_ratio(slope * omega * glm::length(p));
}

glm::dvec2 fisheye(const double*, const glm::dvec2& p) {
  return equidistant(p);
}

glm::dvec2 simple_radial_fisheye(const double* k, const glm::dvec2& p) {
  return simple_radial(k, equidistant(p));
}

glm::dvec2 radial_fisheye(const double* k, const glm::dvec2& p) {
  return radial(k, equidistant(p));
}

glm::dvec2 opencv_fisheye(const double* k, const glm::dvec2& p) {
  const glm::dvec2 q = equidistant(p);
  return q * series<4>({k[0], k[1], k[2], k[3]}, squared_length(q));
}

glm::dvec2 thin_prism_fisheye(const double* k, const glm::dvec2& p) {
  const glm::dvec2 q = equidistant(p);
  const double r2 = squared_length(q);
  return q * series<4>({k[0], k[1], k[4], k[5]}, r2) + tangential(k[2], k[3], q) + glm::dvec2(k[6], k[7]) * r2;
}

// Unlike in the other models, tangential and prism terms see the point that the radial term has moved.
glm::dvec2 rad_tan_thin_prism_fisheye(const double* k, const glm::dvec2& p) {
  const glm::dvec2 undistorted = equidistant(p);
  const glm::dvec2 q = undistorted * series<6>({k[0], k[1], k[2], k[3], k[4], k[5]}, squared_length(undistorted));
  const double r2 = squared_length(q);
  const double r4 = r2 * r2;
  return q + tangential(k[7], k[6], q) + glm::dvec2(k[8] * r2 + k[9] * r4, k[10] * r2 + k[11] * r4);
}

// Solves p = q / (1 + k |q|^2) for the q that is p at k = 0.
glm::dvec2 division(const double* k, const glm::dvec2& p) {
  return p * (2 / (1 + std::sqrt(1 - 4 * k[0] * squared_length(p))));
}

glm::dvec2 eucm(const double* k, const glm::dvec2& p) {
  const double alpha = k[0];
  const double beta = k[1];
  return p / (alpha * std::sqrt(beta * squared_length(p) + 1) + 1 - alpha);
}

// Brown's radial and tangential terms, and a skew that adds k[0] times y to x. The coefficients are the skew, k1 to k4,
// and p1 to p4, of which the last two grow the tangential terms with the radius.
glm::dvec2 brown(const double* k, const glm::dvec2& p) {
  const double r2 = squared_length(p);
  const glm::dvec2 bent =
      p * series<4>({k[1], k[2], k[3], k[4]}, r2) + tangential(k[5], k[6], p) * series<2>({k[7], k[8]}, r2);
  return {bent.x + k[0] * bent.y, bent.y};
}

glm::dvec2 brown_fisheye(const double* k, const glm::dvec2& p) {
  return brown(k, equidistant(p));
}

struct Description {
  std::string_view name;
  std::size_t focal_count;  // 1: one for both axes
  std::size_t parameter_count;
  std::string_view parameters;
  Distortion distortion;  // null: a panorama
  bool fisheye;           // distorted even with every coefficient 0
};

// The models stand in the order of LensModel.
constexpr std::array<Description, kLensModelCount> kDescriptions{{
    {"SIMPLE_PINHOLE", 1, 3, "f, cx, cy", identity, false},
    {"PINHOLE", 2, 4, "fx, fy, cx, cy", identity, false},
    {"SIMPLE_RADIAL", 1, 4, "f, cx, cy, k", simple_radial, false},
    {"RADIAL", 1, 5, "f, cx, cy, k1, k2", radial, false},
    {"OPENCV", 2, 8, "fx, fy, cx, cy, k1, k2, p1, p2", opencv, false},
    {"OPENCV_FISHEYE", 2, 8, "fx, fy, cx, cy, k1, k2, k3, k4", opencv_fisheye, true},
    {"FULL_OPENCV", 2, 12, "fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6", full_opencv, false},
    {"FOV", 2, 5, "fx, fy, cx, cy, omega", fov, false},
    {"SIMPLE_RADIAL_FISHEYE", 1, 4, "f, cx, cy, k", simple_radial_fisheye, true},
    {"RADIAL_FISHEYE", 1, 5, "f, cx, cy, k1, k2", radial_fisheye, true},
    {"THIN_PRISM_FISHEYE", 2, 12, "fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, sx1, sy1", thin_prism_fisheye, true},
    {"RAD_TAN_THIN_PRISM_FISHEYE", 2, 16, "fx, fy, cx, cy, k0, k1, k2, k3, k4, k5, p0, p1, s0, s1, s2, s3",
     rad_tan_thin_prism_fisheye, true},
    {"SIMPLE_DIVISION", 1, 4, "f, cx, cy, k", division, false},
    {"DIVISION", 2, 5, "fx, fy, cx, cy, k", division, false},
    {"SIMPLE_FISHEYE", 1, 3, "f, cx, cy", fisheye, true},
    {"FISHEYE", 2, 4, "fx, fy, cx, cy", fisheye, true},
    {"EUCM", 2, 6, "fx, fy, cx, cy, alpha, beta", eucm, false},
    {"EQUIRECTANGULAR", 0, 2, "w, h", nullptr, false},
    {"BROWN", 2, 13, "fx, fy, cx, cy, skew, k1, k2, k3, k4, p1, p2, p3, p4", brown, false},
    {"BROWN_FISHEYE", 2, 13, "fx, fy, cx, cy, skew, k1, k2, k3, k4, p1, p2, p3, p4", brown_fisheye, true},
}};

const Description& description(LensModel model) {
  const auto index = static_cast<std::int32_t>(model);
  if (index < 0 || index >= kLensModelCount) {
    throw std::invalid_argument("lens: model is " + std::to_string(index) + ", must be in [0, 19]");
  }
  return kDescriptions[static_cast<std::size_t>(index)];
}

const double* coefficients(const CameraModel& lens) {
  return lens.parameters.data() + description(lens.model).focal_count + 2;
}

// The name of the i-th parameter, cut from the list.
std::string_view parameter_name(LensModel model, std::size_t index) {
  std::string_view rest = parameter_names(model);
  for (; index > 0; --index) {
    rest.remove_prefix(rest.find(',') + 2);
  }
  return rest.substr(0, rest.find(','));
}

[[noreturn]] void refuse(std::string_view field, double value, std::string_view rule) {
  std::array<char, 32> number{};
  std::snprintf(number.data(), number.size(), "%.10g", value);
  throw std::invalid_argument(std::string(field) + " is " + number.data() + ", must be " + std::string(rule));
}

void check_principal_point(const CameraModel& lens) {
  constexpr double kFarthest = 1e6;
  const std::size_t first = description(lens.model).focal_count;
  for (std::size_t i = first; first > 0 && i < first + 2; ++i) {
    if (std::abs(lens.parameters[i]) > kFarthest) {
      refuse(parameter_name(lens.model, i), lens.parameters[i], "in [-1000000, 1000000]");
    }
  }
}

void check_coefficients(const CameraModel& lens) {
  const double* k = coefficients(lens);
  if (lens.model == LensModel::kFov && std::abs(k[0]) >= std::numbers::pi) {
    refuse("omega", k[0], "in (-pi, pi)");
  }
  if (lens.model == LensModel::kEucm && (k[0] < 0 || k[0] > 1)) {
    refuse("alpha", k[0], "in [0, 1]");
  }
  if (lens.model == LensModel::kEucm && k[1] <= 0) {
    refuse("beta", k[1], "positive");
  }
}

// The distortion's change of area, by differences: the area of a small square's image over the square's, negative if it
// is turned over.
double jacobian_determinant(Distortion distortion, const double* k, const glm::dvec2& p) {
  const double step = 1e-6 * (1 + glm::length(p));
  const glm::dvec2 dx = distortion(k, p + glm::dvec2(step, 0)) - distortion(k, p - glm::dvec2(step, 0));
  const glm::dvec2 dy = distortion(k, p + glm::dvec2(0, step)) - distortion(k, p - glm::dvec2(0, step));
  return (dx.x * dy.y - dx.y * dy.x) / (4 * step * step);
}

constexpr double kSmallestArea = 1.0 / (20 * 20);  // a place shrunk more is the start of a fold

// Along one direction, the radius up to which the image keeps its orientation.
double reach_along(const CameraModel& lens, const glm::dvec2& direction, double limit) {
  const Distortion distortion = description(lens.model).distortion;
  const double* k = coefficients(lens);
  const auto upright = [&](double radius) {  // false for NaN
    const glm::dvec2 image = distortion(k, radius * direction);
    return jacobian_determinant(distortion, k, radius * direction) > kSmallestArea && glm::dot(image, direction) >= 0;
  };
  constexpr int kSteps = 256;
  constexpr int kHalvings = 30;
  for (int i = 0; i <= kSteps; ++i) {
    if (upright(limit * i / kSteps)) {
      continue;
    }
    double inside = limit * std::max(i - 1, 0) / kSteps;
    double outside = limit * i / kSteps;
    for (int halving = 0; halving < kHalvings; ++halving) {
      const double middle = (inside + outside) / 2;
      (upright(middle) ? inside : outside) = middle;
    }
    return inside;
  }
  return limit;
}

}  // namespace

std::optional<LensModel> lens_model(std::int32_t colmap_id) {
  if (colmap_id < 0 || colmap_id >= kColmapModelCount) {
    return std::nullopt;
  }
  return static_cast<LensModel>(colmap_id);
}

std::optional<LensModel> lens_model(std::string_view colmap_name) {
  for (std::int32_t id = 0; id < kColmapModelCount; ++id) {
    if (kDescriptions[static_cast<std::size_t>(id)].name == colmap_name) {
      return static_cast<LensModel>(id);
    }
  }
  return std::nullopt;
}

std::string_view name(LensModel model) {
  return description(model).name;
}

std::size_t parameter_count(LensModel model) {
  return description(model).parameter_count;
}

std::string_view parameter_names(LensModel model) {
  return description(model).parameters;
}

glm::dvec2 CameraModel::focal_length() const {
  const std::size_t count = description(model).focal_count;
  return count == 0 ? glm::dvec2(0.0) : glm::dvec2(parameters[0], parameters[count - 1]);
}

glm::dvec2 CameraModel::principal_point() const {
  const std::size_t count = description(model).focal_count;
  return count == 0 ? glm::dvec2(0.0) : glm::dvec2(parameters[count], parameters[count + 1]);
}

void check(const CameraModel& lens) {
  constexpr std::uint32_t kMaxSize = 65536;
  if (lens.width < 1 || lens.width > kMaxSize) {
    refuse("width", lens.width, "in [1, 65536]");
  }
  if (lens.height < 1 || lens.height > kMaxSize) {
    refuse("height", lens.height, "in [1, 65536]");
  }
  for (std::size_t i = 0; i < parameter_count(lens.model); ++i) {
    if (!std::isfinite(lens.parameters[i])) {
      refuse(parameter_name(lens.model, i), lens.parameters[i], "finite");
    }
  }
  for (std::size_t i = 0; i < description(lens.model).focal_count; ++i) {
    if (lens.parameters[i] <= 0) {
      refuse(parameter_name(lens.model, i), lens.parameters[i], "positive");
    }
  }
  check_principal_point(lens);
  check_coefficients(lens);
}

namespace {

// The model of two focal lengths, in place of one, that has the same distortion; its coefficients begin with the
// same ones, and the others are 0.
LensModel with_two_focal_lengths(LensModel model) {
  switch (model) {
    case LensModel::kSimplePinhole:
      return LensModel::kPinhole;
    case LensModel::kSimpleRadial:
    case LensModel::kRadial:
      return LensModel::kOpenCv;
    case LensModel::kSimpleRadialFisheye:
    case LensModel::kRadialFisheye:
      return LensModel::kOpenCvFisheye;
    case LensModel::kSimpleDivision:
      return LensModel::kDivision;
    case LensModel::kSimpleFisheye:
      return LensModel::kFisheye;
    default:
      return model;
  }
}

}  // namespace

CameraModel scaled(const CameraModel& lens, std::uint32_t width, std::uint32_t height) {
  const glm::dvec2 factor(static_cast<double>(width) / lens.width, static_cast<double>(height) / lens.height);
  CameraModel result = lens;
  result.width = width;
  result.height = height;
  if (lens.model == LensModel::kEquirectangular) {
    result.parameters = {static_cast<double>(width), static_cast<double>(height)};
    return result;
  }
  if (factor.x != factor.y) result.model = with_two_focal_lengths(lens.model);
  const std::size_t focal_count = description(result.model).focal_count;
  const glm::dvec2 focal = lens.focal_length() * factor, middle = lens.principal_point() * factor;
  result.parameters = {};
  result.parameters[0] = focal.x;
  result.parameters[focal_count - 1] = focal_count == 1 ? focal.x : focal.y;
  result.parameters[focal_count] = middle.x;
  result.parameters[focal_count + 1] = middle.y;
  std::copy_n(coefficients(lens), parameter_count(lens.model) - description(lens.model).focal_count - 2,
              result.parameters.begin() + static_cast<std::ptrdiff_t>(focal_count) + 2);
  return result;
}

bool can_be_pinhole(LensModel model) {
  return description(model).distortion != nullptr;
}

bool is_distorted(const CameraModel& lens) {
  const Description& d = description(lens.model);
  if (d.distortion == nullptr || d.fisheye) {
    return true;
  }
  if (lens.model == LensModel::kEucm) {
    return coefficients(lens)[0] != 0;  // beta means nothing without alpha
  }
  for (std::size_t i = d.focal_count + 2; i < d.parameter_count; ++i) {
    if (lens.parameters[i] != 0) {
      return true;
    }
  }
  return false;
}

std::optional<glm::dvec2> image_from_cam(const CameraModel& lens, const glm::dvec3& cam) {
  const Description& d = description(lens.model);
  if (d.distortion == nullptr) {
    throw std::invalid_argument("lens: model is " + std::string(d.name) + ", must be one that can be a pinhole view");
  }
  if (!(cam.z > 0)) {
    return std::nullopt;
  }
  const glm::dvec2 distorted = d.distortion(coefficients(lens), {cam.x / cam.z, cam.y / cam.z});
  const glm::dvec2 image = lens.focal_length() * distorted + lens.principal_point();
  if (!std::isfinite(image.x) || !std::isfinite(image.y)) {
    return std::nullopt;
  }
  return image;
}

double reach(const CameraModel& lens, double limit) {
  if (!can_be_pinhole(lens.model)) {
    throw std::invalid_argument("lens: model is " + std::string(name(lens.model)) +
                                ", must be one that can be a pinhole view");
  }
  constexpr int kDirections = 16;  // tangential and prism terms move a fold by a few percent between directions
  double least = limit;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2 * std::numbers::pi * i / kDirections;
    least = std::min(least, reach_along(lens, {std::cos(angle), std::sin(angle)}, least));
  }
  return least;
}

}  // namespace lumatlas
