// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/lenses/camera_model.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/scene/lenses/undistortion.h"

namespace lumatlas {
namespace {

constexpr double kPi = std::numbers::pi;

CameraModel lens_of(LensModel model, std::uint32_t width, std::uint32_t height, const std::vector<double>& parameters) {
  REQUIRE(parameters.size() == parameter_count(model));
  CameraModel lens{model, width, height, {}};
  std::copy(parameters.begin(), parameters.end(), lens.parameters.begin());
  return lens;
}

// Focal lengths 100 (and 200 for y where the model has two), principal point (50, 40).
CameraModel lens_with(LensModel model, const std::vector<double>& coefficients) {
  const bool two = parameter_names(model).starts_with("fx");
  std::vector<double> parameters = two ? std::vector<double>{100, 200, 50, 40} : std::vector<double>{100, 50, 40};
  parameters.insert(parameters.end(), coefficients.begin(), coefficients.end());
  return lens_of(model, 100, 80, parameters);
}

// Every model that can be a pinhole view, with some distortion.
std::vector<CameraModel> one_of_each() {
  using enum LensModel;
  return {lens_with(kSimplePinhole, {}),
          lens_with(kPinhole, {}),
          lens_with(kSimpleRadial, {-0.1}),
          lens_with(kRadial, {-0.1, 0.02}),
          lens_with(kOpenCv, {-0.1, 0.02, 0.001, -0.002}),
          lens_with(kOpenCvFisheye, {-0.03, 0.01, 0.002, -0.001}),
          lens_with(kFullOpenCv, {-0.1, 0.02, 0.001, -0.002, 0.01, 0.05, 0.02, 0.01}),
          lens_with(kFov, {0.9}),
          lens_with(kSimpleRadialFisheye, {-0.03}),
          lens_with(kRadialFisheye, {-0.03, 0.01}),
          lens_with(kThinPrismFisheye, {-0.03, 0.01, 0.001, -0.002, 0.002, 0.001, 0.003, -0.002}),
          lens_with(kRadTanThinPrismFisheye, {-0.03, 0.01, 0.002, 0.001, 0, 0, 0.001, 0.002, 0.003, 0, -0.002, 0.001}),
          lens_with(kSimpleDivision, {-0.2}),
          lens_with(kDivision, {-0.2}),
          lens_with(kSimpleFisheye, {}),
          lens_with(kFisheye, {}),
          lens_with(kEucm, {0.5, 1.1}),
          lens_with(kBrown, {0.01, -0.1, 0.02, 0.01, -0.003, 0.001, -0.002, 0.1, -0.05}),
          lens_with(kBrownFisheye, {0.01, -0.03, 0.01, 0.002, -0.001, 0.001, -0.002, 0.1, -0.05})};
}

// Returns the position at which the lens images the direction, in units of the focal lengths from the principal point.
glm::dvec2 distorted(const CameraModel& lens, const glm::dvec3& direction) {
  const std::optional<glm::dvec2> image = image_from_cam(lens, direction);
  REQUIRE(image);
  return (*image - lens.principal_point()) / lens.focal_length();
}

void check_near(const glm::dvec2& value, const glm::dvec2& expected) {
  CHECK(value.x == Approx(expected.x).margin(1e-12));
  CHECK(value.y == Approx(expected.y).margin(1e-12));
}

TEST_CASE("COLMAP's numbers and names lead to the same model, and no others do") {
  for (std::int32_t id = 0; id < kColmapModelCount; ++id) {
    const std::optional<LensModel> model = lens_model(id);
    REQUIRE(model);
    CHECK(lens_model(name(*model)) == model);
  }
  CHECK(name(LensModel::kPinhole) == "PINHOLE");
  CHECK(lens_model("FULL_OPENCV") == LensModel::kFullOpenCv);
  CHECK_FALSE(lens_model(-1));
  CHECK_FALSE(lens_model(kColmapModelCount));
  CHECK_FALSE(lens_model("BROWN"));  // of lumatlas alone
  CHECK_FALSE(lens_model("pinhole"));
  CHECK_FALSE(lens_model(""));
}

TEST_CASE("the names of the parameters are as many as the parameters") {
  for (std::int32_t id = 0; id < kLensModelCount; ++id) {
    const auto model = static_cast<LensModel>(id);
    const std::string_view names = parameter_names(model);
    CHECK(static_cast<std::size_t>(std::count(names.begin(), names.end(), ',')) + 1 == parameter_count(model));
  }
}

TEST_CASE("the axis is imaged at the principal point by every model") {
  for (const CameraModel& lens : one_of_each()) {
    INFO(name(lens.model));
    CHECK(glm::length(*image_from_cam(lens, {0, 0, 3}) - glm::dvec2(50, 40)) < 1e-12);
  }
}

TEST_CASE("the image depends on the direction, not on its length, and nothing behind the camera has one") {
  for (const CameraModel& lens : one_of_each()) {
    INFO(name(lens.model));
    CHECK(glm::length(distorted(lens, {0.3, -0.4, 1}) - distorted(lens, {0.9, -1.2, 3})) < 1e-12);
    CHECK_FALSE(image_from_cam(lens, {0.3, -0.4, -1}));
    CHECK_FALSE(image_from_cam(lens, {0.3, -0.4, 0}));
    CHECK_FALSE(image_from_cam(lens, {0, 0, std::numeric_limits<double>::quiet_NaN()}));
  }
}

TEST_CASE("near the axis every model but FOV has its focal length as scale") {
  for (const CameraModel& lens : one_of_each()) {
    INFO(name(lens.model));
    const double scale = lens.model == LensModel::kFov ? 2 * std::tan(0.45) / 0.9 : 1;
    CHECK(distorted(lens, {1e-5, 0, 1}).x / 1e-5 == Approx(scale).epsilon(1e-6));
    CHECK(distorted(lens, {0, 1e-5, 1}).y / 1e-5 == Approx(scale).epsilon(1e-6));
  }
}

TEST_CASE("a perspective model with every coefficient 0 is a pinhole, a fisheye is not") {
  const glm::dvec3 direction(0.3, -0.4, 1);
  using enum LensModel;
  for (const LensModel model : {kSimplePinhole, kPinhole, kSimpleRadial, kRadial, kOpenCv, kFullOpenCv, kFov,
                                kSimpleDivision, kDivision, kEucm, kBrown}) {
    INFO(name(model));
    CameraModel lens = lens_with(
        model, std::vector<double>(parameter_count(model) - (parameter_names(model).starts_with("fx") ? 4 : 3)));
    if (model == kEucm) lens.parameters[5] = 1;
    CHECK_FALSE(is_distorted(lens));
    check_near(distorted(lens, direction), {0.3, -0.4});
  }
  CHECK(is_distorted(lens_with(kSimpleFisheye, {})));
  CHECK(is_distorted(lens_with(kOpenCvFisheye, {0, 0, 0, 0})));
  CHECK(is_distorted(lens_with(kSimpleRadial, {1e-9})));
}

// At (0.3, -0.4), whose squared radius is 1/4.
TEST_CASE("perspective models give the values worked by hand") {
  const glm::dvec3 d(0.3, -0.4, 1);
  using enum LensModel;
  CHECK(*image_from_cam(lens_with(kSimplePinhole, {}), d) == glm::dvec2(80, 0));
  CHECK(*image_from_cam(lens_with(kPinhole, {}), d) == glm::dvec2(80, -40));
  check_near(distorted(lens_with(kSimpleRadial, {0.4}), d), {0.33, -0.44});
  check_near(distorted(lens_with(kRadial, {0.4, 0.16}), d), {0.333, -0.444});
  check_near(distorted(lens_with(kOpenCv, {0.4, 0.16, 0.1, 0.2}), d), {0.333 + 0.062, -0.444 + 0.009});
  check_near(distorted(lens_with(kFullOpenCv, {0.4, 0.16, 0.1, 0.2, 0.64, 0.8, 0, 0}), d),
             {0.3 * 1.12 / 1.2 + 0.062, -0.4 * 1.12 / 1.2 + 0.009});
  check_near(distorted(lens_with(kFullOpenCv, {0, 0, 0, 0, 0, 0, 0.16, 0.64}), d), {0.3 / 1.02, -0.4 / 1.02});
  // Radial terms of 1/10 to 1/10000, tangential ones as above times 1.11, and half of y added to x.
  const std::vector<double> brown{0.5, 0.4, 0.16, 0.064, 0.0256, 0.1, 0.2, 0.4, 0.16};
  const double y = -0.4 * 1.1111 + 0.009 * 1.11;
  check_near(distorted(lens_with(kBrown, brown), d), {0.3 * 1.1111 + 0.062 * 1.11 + 0.5 * y, y});
  // The point (0.3, -0.4) / (1 - 0.8 / 4) is the one that the division model moves to (0.3, -0.4).
  check_near(distorted(lens_with(kSimpleDivision, {-0.8}), {0.375, -0.5, 1}), {0.3, -0.4});
  check_near(distorted(lens_with(kDivision, {-0.8}), {0.375, -0.5, 1}), {0.3, -0.4});
  // alpha sqrt(beta r^2 + 1) + 1 - alpha = 3/2 for r = 1.
  check_near(distorted(lens_with(kEucm, {0.5, 3}), {0.6, 0.8, 1}), {0.4, 0.8 / 1.5});
}

TEST_CASE("the FOV model gives the values worked by hand, also for a tiny omega") {
  const CameraModel quarter = lens_with(LensModel::kFov, {kPi / 2});
  check_near(distorted(quarter, {std::sqrt(3.0) / 2, 0, 1}), {2.0 / 3, 0});  // atan(sqrt 3) / (pi / 2)
  check_near(distorted(quarter, {0, -0.5, 1}), {0, -0.5});                   // atan(1) / (pi / 2)
  const glm::dvec2 above = distorted(lens_with(LensModel::kFov, {1.0001e-4}), {0.3, -0.4, 1});
  const glm::dvec2 below = distorted(lens_with(LensModel::kFov, {0.9999e-4}), {0.3, -0.4, 1});
  CHECK(glm::length(above - below) < 1e-11);  // the series takes over without a step
}

// At 60 degrees from the axis, towards (0.6, 0.8); coefficients that make each radial term a power of 1/10.
TEST_CASE("fisheye models give the values worked by hand") {
  const double theta = kPi / 3;
  const glm::dvec3 d(0.6 * std::sqrt(3.0), 0.8 * std::sqrt(3.0), 1);
  const double c = 0.1 / (theta * theta);
  using enum LensModel;
  check_near(distorted(lens_with(kSimpleFisheye, {}), d), {0.6 * theta, 0.8 * theta});
  check_near(distorted(lens_with(kFisheye, {}), d), {0.6 * theta, 0.8 * theta});
  check_near(distorted(lens_with(kSimpleRadialFisheye, {c}), d), {0.66 * theta, 0.88 * theta});
  check_near(distorted(lens_with(kRadialFisheye, {c, c * c}), d), {0.666 * theta, 0.888 * theta});
  check_near(distorted(lens_with(kOpenCvFisheye, {c, c * c, std::pow(c, 3), std::pow(c, 4)}), d),
             {0.66666 * theta, 0.88888 * theta});
  check_near(distorted(lens_with(kThinPrismFisheye, {c, c * c, 0.1 / theta, 0.2 / theta, std::pow(c, 3), std::pow(c, 4),
                                                     0.3 / theta, 0.4 / theta}),
                       d),
             {(0.66666 + 0.44 + 0.3) * theta, (0.88888 + 0.42 + 0.4) * theta});
  const double y = (0.88888 + 0.42 * 1.11) * theta;
  check_near(distorted(lens_with(kBrownFisheye,
                                 {0.5, c, c * c, std::pow(c, 3), std::pow(c, 4), 0.1 / theta, 0.2 / theta, c, c * c}),
                       d),
             {(0.66666 + 0.44 * 1.11) * theta + 0.5 * y, y});
}

TEST_CASE("the fisheye of sixteen parameters gives the values worked by hand") {
  const double theta = kPi / 3;
  const glm::dvec3 d(0.6 * std::sqrt(3.0), 0.8 * std::sqrt(3.0), 1);
  const double c = 0.1 / (theta * theta);
  using enum LensModel;
  std::vector<double> radial{c, c * c, std::pow(c, 3), std::pow(c, 4), std::pow(c, 5), std::pow(c, 6)};
  radial.resize(12);
  check_near(distorted(lens_with(kRadTanThinPrismFisheye, radial), d), {0.6666666 * theta, 0.8888888 * theta});
  const double R = 1.1 * theta;
  const std::vector<double> all{
      c, 0, 0, 0, 0, 0, 0.1 / R, 0.2 / R, 0.3 / R, 0.1 / (R * R * R), 0.2 / R, 0.1 / (R * R * R)};
  check_near(distorted(lens_with(kRadTanThinPrismFisheye, all), d), {(0.6 + 0.364 + 0.4) * R, (0.8 + 0.552 + 0.3) * R});
}

TEST_CASE("a panorama is refused by name") {
  const CameraModel lens = lens_of(LensModel::kEquirectangular, 200, 100, {200, 100});
  CHECK_NOTHROW(check(lens));
  CHECK_FALSE(can_be_pinhole(lens.model));
  CHECK_THROWS_WITH(pinhole_view(lens),
                    "lens model EQUIRECTANGULAR is a full panorama, which no pinhole view can hold: render views of it "
                    "first");
  CHECK_THROWS_AS(image_from_cam(lens, {0, 0, 1}), std::invalid_argument);
  CHECK_THROWS_AS(reach(lens, 1), std::invalid_argument);
}

TEST_CASE("a lens reaches up to the fold of its distortion") {
  using enum LensModel;
  // d(r) = r - r^3 / 2 turns at sqrt(2/3); a little before it shrinks 20 times.
  const double fold = std::sqrt(2.0 / 3);
  const double folding = reach(lens_with(kSimpleRadial, {-0.5}), 10);
  CHECK(folding < fold);
  CHECK(folding > 0.99 * fold);
  CHECK(reach(lens_with(kSimpleRadial, {-0.5}), 0.5) == 0.5);
  CHECK(reach(lens_with(kSimpleRadial, {0.5}), 10) == 10);
  CHECK(reach(lens_with(kFullOpenCv, {0, 0, 0, 0, 0, -1, 0, 0}), 10) <= 1);  // a pole at 1
  CHECK(reach(lens_with(kDivision, {0.25}), 10) <= 1);                       // no image beyond 1
  CHECK(reach(lens_with(kOpenCv, {0, 0, 0, -0.25}), 10) < 0.7);              // x - 3/4 x^2 turns at 2/3
  CHECK(reach(lens_with(kSimpleRadial, {std::numeric_limits<double>::max()}), 10) == 0);
}

TEST_CASE("inside its reach a lens images different directions apart, outwards in every direction") {
  for (const CameraModel& lens : one_of_each()) {
    INFO(name(lens.model));
    const double end = reach(lens, 1.2);
    CHECK(end > 0.5);
    for (int azimuth = 0; azimuth < 37; ++azimuth) {
      const glm::dvec2 direction(std::cos(0.17 * azimuth), std::sin(0.17 * azimuth));
      double before = 0;
      for (int i = 1; i <= 50; ++i) {
        const glm::dvec2 p = direction * (end * i / 50);
        const double outwards = glm::dot(distorted(lens, {p, 1}), direction);
        CHECK(outwards > before);
        before = outwards;
      }
    }
  }
}

// The view without distortion that looks at direction (x, y, 1) has this colour there; smooth, and different along x,
// y.
glm::dvec3 pattern(const glm::dvec2& p) {
  return glm::dvec3(128 + 60 * p.x, 128 + 60 * p.y, 128 + 40 * std::sin(6 * p.x) * std::cos(6 * p.y));
}

// The direction that the lens images at a place, by Newton's method; none if that fails or lies beyond the fold.
std::optional<glm::dvec2> direction_of(const CameraModel& lens, const glm::dvec2& place, double end) {
  const auto f = [&](const glm::dvec2& p) { return image_from_cam(lens, {p, 1}).value_or(glm::dvec2(1e9)); };
  glm::dvec2 p = (place - lens.principal_point()) / lens.focal_length();
  p *= std::min(1.0, 0.9 * end / std::max(glm::length(p), 1e-9));
  for (int i = 0; i < 30; ++i) {
    const double h = 1e-6;
    const glm::dvec2 value = f(p);
    const glm::dmat2 jacobian((f(p + glm::dvec2(h, 0)) - value) / h, (f(p + glm::dvec2(0, h)) - value) / h);
    p -= glm::inverse(jacobian) * (value - place);
  }
  const bool found = glm::length(p) <= end && glm::length(f(p) - place) < 1e-6;
  return found ? std::optional(p) : std::nullopt;
}

// The photograph that the lens takes of the pattern; black where it sees nothing.
Photograph distorted_photograph(const CameraModel& lens) {
  const double end = reach(lens, 5);
  Photograph photograph{lens.width, lens.height, {}, {}};
  for (std::uint32_t y = 0; y < lens.height; ++y) {
    for (std::uint32_t x = 0; x < lens.width; ++x) {
      const std::optional<glm::dvec2> p = direction_of(lens, {x + 0.5, y + 0.5}, end);
      const glm::dvec3 color = p ? glm::clamp(pattern(*p), 0.0, 255.0) : glm::dvec3(0);
      for (int c = 0; c < 3; ++c) photograph.rgb.push_back(static_cast<std::uint8_t>(std::lround(color[c])));
    }
  }
  return photograph;
}

bool is_valid(const Photograph& photograph, std::size_t pixel) {
  return photograph.valid.empty() || photograph.valid[pixel] != 0;
}

// The largest difference to the pattern over the valid pixels.
double largest_error(const Photograph& picture, const Camera& view) {
  double largest = 0;
  for (std::uint32_t y = 0; y < view.height; ++y) {
    for (std::uint32_t x = 0; x < view.width; ++x) {
      const std::size_t pixel = std::size_t{y} * view.width + x;
      if (!is_valid(picture, pixel)) continue;
      const glm::dvec3 expected = pattern({(x + 0.5 - view.cx) / view.fx, (y + 0.5 - view.cy) / view.fy});
      for (int c = 0; c < 3; ++c) {
        const double got = picture.rgb[3 * pixel + static_cast<std::size_t>(c)];
        largest = std::max(largest, std::abs(got - std::clamp(expected[c], 0.0, 255.0)));
      }
    }
  }
  return largest;
}

std::size_t valid_pixels(const Photograph& picture) {
  return picture.valid.empty() ? picture.rgb.size() / 3
                               : static_cast<std::size_t>(std::count(picture.valid.begin(), picture.valid.end(), 255));
}

TEST_CASE("undistorting a distorted photograph of a pattern gives the pattern") {
  using enum LensModel;
  const std::vector<CameraModel> lenses{
      lens_of(kSimpleRadial, 160, 120, {150, 83, 58, -0.15}),
      lens_of(kSimpleRadial, 160, 120, {150, 83, 58, 0.15}),
      lens_of(kOpenCv, 160, 120, {150, 155, 83, 58, -0.1, 0.02, 0.005, -0.004}),
      lens_of(kFullOpenCv, 160, 120, {150, 155, 83, 58, -0.1, 0.02, 0.005, -0.004, 0, 0.1, 0, 0}),
      lens_of(kFov, 160, 120, {150, 155, 83, 58, 0.8}),
      lens_of(kOpenCvFisheye, 160, 120, {90, 92, 83, 58, -0.03, 0.01, 0, 0}),
      lens_of(kThinPrismFisheye, 160, 120, {90, 92, 83, 58, -0.03, 0.01, 0.002, 0.003, 0, 0, 0.004, 0.002}),
      lens_of(kRadTanThinPrismFisheye, 160, 120,
              {90, 92, 83, 58, -0.03, 0.01, 0, 0, 0, 0, 0.002, 0.003, 0.004, 0, 0.002, 0}),
      lens_of(kDivision, 160, 120, {150, 155, 83, 58, -0.2}),
      lens_of(kEucm, 160, 120, {150, 155, 83, 58, 0.5, 1.1}),
  };
  for (const CameraModel& lens : lenses) {
    INFO(name(lens.model));
    const Camera view = pinhole_view(lens);
    const Photograph picture = undistort(distorted_photograph(lens), lens, view);
    CHECK(valid_pixels(picture) > 160 * 120 * 95 / 100);
    CHECK(largest_error(picture, view) <= 2.5);  // rounding of the photograph and of the result, and half a pixel's
                                                 // clamping at the border
  }
}

TEST_CASE("undistorting by a wrong lens and by what is wrong with it gives the pattern") {
  const CameraModel lens = lens_of(LensModel::kOpenCv, 160, 120, {150, 150, 83, 58, -0.1, 0.02, 0.005, -0.004});
  const LensCorrection correction{150 / 140.0, {3 / 160.0, -2 / 160.0}, -0.1, 0.02, 0.005, -0.004};
  const CameraModel given = lens_of(LensModel::kPinhole, 160, 120, {140, 140, 80, 60});
  const Camera view = pinhole_view(given);
  const Photograph picture = undistort(distorted_photograph(lens), given, view, correction);
  CHECK(valid_pixels(picture) > 160 * 120 * 9 / 10);
  CHECK(largest_error(picture, view) <= 2.5);
  LensCorrection broken;
  broken.k1 = std::nan("");
  CHECK_THROWS_AS(undistort(distorted_photograph(lens), given, view, broken), std::invalid_argument);

  // A given distortion and one on top of it are undone at once.
  const CameraModel half = lens_of(LensModel::kSimpleRadial, 160, 120, {150, 80, 60, -0.05});
  const CameraModel whole = lens_of(LensModel::kSimpleRadial, 160, 120, {150, 80, 60, -0.1});
  const Photograph both = undistort(distorted_photograph(whole), half, pinhole_view(half), {1, {0, 0}, -0.05, 0, 0, 0});
  CHECK(largest_error(both, pinhole_view(half)) <= 6);  // to first order
}

TEST_CASE("a pinhole's photograph is returned untouched, and so is that of a lens whose coefficients are 0") {
  for (const CameraModel& lens : {lens_with(LensModel::kPinhole, {}), lens_with(LensModel::kSimplePinhole, {}),
                                  lens_with(LensModel::kOpenCv, {0, 0, 0, 0})}) {
    const Camera view = pinhole_view(lens);
    CHECK(view.fx == lens.focal_length().x);
    CHECK(view.fy == lens.focal_length().y);
    Photograph photograph = distorted_photograph(lens);
    const std::vector<std::uint8_t> bytes = photograph.rgb;
    const Photograph picture = undistort(std::move(photograph), lens, view);
    CHECK(picture.rgb == bytes);
    CHECK(picture.valid.empty());
  }
}

TEST_CASE("a barrel lens keeps its focal length and leaves no border") {
  const CameraModel lens = lens_of(LensModel::kSimpleRadial, 640, 480, {600, 320, 240, -0.1});
  const Camera view = pinhole_view(lens);
  CHECK(view.fx == 600);
  CHECK(undistort({640, 480, std::vector<std::uint8_t>(3 * 640 * 480), {}}, lens, view).valid.empty());
}

TEST_CASE("a pincushion lens is magnified just until no border is left") {
  const CameraModel lens = lens_of(LensModel::kSimpleRadial, 640, 480, {600, 320, 240, 0.1});
  const Camera view = pinhole_view(lens);
  CHECK(view.fx > 600);
  CHECK(view.fx < 600 * kLargestZoom);
  CHECK(view.fy / view.fx == 1);
  CHECK(view.cx == 320);
  CHECK(view.cy == 240);
  const Photograph black{640, 480, std::vector<std::uint8_t>(3 * 640 * 480), {}};
  CHECK(undistort(black, lens, view).valid.empty());
  Camera wider = view;
  wider.fx *= 0.998;
  wider.fy *= 0.998;
  CHECK_FALSE(undistort(black, lens, wider).valid.empty());
}

TEST_CASE("a strong pincushion lens keeps its whole field of view, and the border is marked") {
  const CameraModel lens = lens_of(LensModel::kSimpleRadial, 320, 240, {300, 160, 120, 0.6});
  const Camera view = pinhole_view(lens);
  CHECK(view.fx == 300);
  const Photograph picture = undistort(distorted_photograph(lens), lens, view);
  REQUIRE(picture.valid.size() == 320 * 240);
  CHECK(picture.valid[0] == 0);
  CHECK(picture.valid[120 * 320 + 160] == 255);
  CHECK(picture.rgb[0] == 0);
  for (std::uint32_t y = 0; y < 240; ++y) {
    for (std::uint32_t x = 0; x < 320; ++x) {
      const std::optional<glm::dvec2> source =
          image_from_cam(lens, {(x + 0.5 - view.cx) / view.fx, (y + 0.5 - view.cy) / view.fy, 1});
      const bool inside = source->x >= 0 && source->y >= 0 && source->x <= 320 && source->y <= 240;
      if (inside != is_valid(picture, y * 320 + x)) FAIL("wrong mask at " << x << ", " << y);
    }
  }
}

TEST_CASE("nothing is fetched from beyond a fold") {
  const CameraModel lens = lens_of(LensModel::kSimpleRadial, 320, 240, {200, 160, 120, -0.5});
  const Camera view = pinhole_view(lens);
  const Photograph picture = undistort(distorted_photograph(lens), lens, view);
  REQUIRE_FALSE(picture.valid.empty());
  const double fold = std::sqrt(2.0 / 3);
  for (std::uint32_t y = 0; y < 240; ++y) {
    for (std::uint32_t x = 0; x < 320; ++x) {
      const glm::dvec2 p((x + 0.5 - view.cx) / view.fx, (y + 0.5 - view.cy) / view.fy);
      if (glm::length(p) > fold && is_valid(picture, y * 320 + x)) FAIL("folded pixel " << x << ", " << y);
      if (glm::length(p) < 0.97 * fold && !is_valid(picture, y * 320 + x)) FAIL("lost pixel " << x << ", " << y);
    }
  }
}

TEST_CASE("a fisheye that sees more than half a sphere gives a view of its middle") {
  const CameraModel lens = lens_of(LensModel::kSimpleFisheye, 400, 300, {80, 200, 150});  // 143 degrees to each side
  const Camera view = pinhole_view(lens);
  CHECK(view.fx == 80);
  const Photograph picture = undistort(distorted_photograph(lens), lens, view);
  CHECK(valid_pixels(picture) == 400 * 300);
}

TEST_CASE("a lens that folds everything over is refused") {
  CHECK_THROWS_WITH(pinhole_view(lens_with(LensModel::kSimpleRadial, {-1e9})),
                    "its distortion (f, cx, cy, k) folds the picture over, so that no pinhole view of it is left: "
                    "calibrate it anew");
  CHECK_THROWS_AS(pinhole_view(lens_with(LensModel::kOpenCvFisheye, {1e308, -1e308, 1e308, 1e308})),
                  std::invalid_argument);
}

TEST_CASE("the mask of a photograph is carried through undistortion") {
  const CameraModel lens = lens_of(LensModel::kSimpleRadial, 64, 48, {60, 32, 24, -0.1});
  Photograph photograph{64, 48, std::vector<std::uint8_t>(3 * 64 * 48, 200), std::vector<std::uint8_t>(64 * 48, 255)};
  for (std::size_t i = 0; i < photograph.valid.size(); ++i) {
    if (i % 64 < 32) photograph.valid[i] = 0;
  }
  const Photograph picture = undistort(photograph, lens, pinhole_view(lens));
  CHECK(picture.valid[24 * 64 + 10] == 0);
  CHECK(picture.rgb[3 * (24 * 64 + 10)] == 0);
  CHECK(picture.valid[24 * 64 + 50] == 255);
  CHECK(picture.rgb[3 * (24 * 64 + 50)] == 200);
}

TEST_CASE("undistortion gives the same bytes for any number of threads") {
  const CameraModel lens = lens_of(LensModel::kOpenCv, 321, 240, {300, 310, 160, 120, 0.2, 0.1, 0.01, 0});
  const Photograph photograph = distorted_photograph(lens);
  const Camera view = pinhole_view(lens);
  const Photograph parallel = undistort(photograph, lens, view);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Photograph serial = undistort(photograph, lens, view);
  CHECK(parallel.rgb == serial.rgb);
  CHECK(parallel.valid == serial.valid);
}

TEST_CASE("a photograph of one pixel, and one of a column, can be undistorted") {
  for (const std::uint32_t height : {1u, 9u}) {
    const CameraModel lens = lens_of(LensModel::kSimpleRadial, 1, height, {10, 0.5, height / 2.0, 0.1});
    const Photograph photograph{1, height, std::vector<std::uint8_t>(3 * height, 77), {}};
    const Photograph picture = undistort(photograph, lens, pinhole_view(lens));
    CHECK(picture.rgb == photograph.rgb);
  }
}

TEST_CASE("a photograph or a view of another size is refused") {
  const CameraModel lens = lens_with(LensModel::kSimpleRadial, {0.1});
  const Camera view = pinhole_view(lens);
  CHECK_THROWS_WITH(undistort({10, 10, std::vector<std::uint8_t>(300), {}}, lens, view),
                    "undistort: the photograph is 10x10, must be the lens's 100x80");
  CHECK_THROWS_WITH(undistort({100, 80, std::vector<std::uint8_t>(24000), {}}, lens, view.scaled_to(50, 40)),
                    "undistort: the view is 50x40, must be the lens's 100x80");
}

}  // namespace
}  // namespace lumatlas
