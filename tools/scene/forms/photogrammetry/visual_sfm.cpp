// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/photogrammetry/visual_sfm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/scene/forms/fields/text_numbers.h"
#include "tools/scene/forms/fields/text_rows.h"
#include "tools/scene/forms/photographs/measured_size.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kNvmStart = "NVM_V", kNvmVersion = "NVM_V3";

struct NvmCamera {
  std::string_view name;
  std::size_t line = 0;
  double f = 0, r = 0;
  glm::dquat q{1, 0, 0, 0};
  glm::dvec3 center{0.0};
};

struct NvmModel {
  std::vector<NvmCamera> cameras;
  std::vector<MeasuredExtent> extents;  // one per camera
  std::uint64_t points = 0;
};

// The calibration that is fixed for all cameras, pixels.
struct NvmCalibration {
  double fx, cx, fy, cy;
};

// A name may hold blanks where another program wrote the file, so the numbers are counted from the line's end.
NvmCamera nvm_camera(const TextRow& row, const fs::path& path) {
  constexpr std::size_t kNumbers = 10;
  if (row.fields.size() < kNumbers + 1) {
    refuse_row(path, row,
               "has " + std::to_string(row.fields.size()) + " values, but a camera has a file and " +
                   std::to_string(kNumbers) + " numbers");
  }
  const std::size_t first = row.fields.size() - kNumbers;
  const std::string_view last_of_name = row.fields[first - 1];
  const char* const begin = row.fields.front().data();
  const auto number = [&](std::size_t i) { return number_in(row, first + i, path); };
  NvmCamera camera;
  camera.name = {begin, static_cast<std::size_t>(last_of_name.data() + last_of_name.size() - begin)};
  camera.line = row.line;
  camera.f = number(0);
  camera.q = glm::dquat(number(1), number(2), number(3), number(4));
  camera.center = {number(5), number(6), number(7)};
  camera.r = number(8);
  (void)number(9);
  return camera;
}

std::string nvm_name(std::string_view written) {
  std::string name(written);
  std::replace(name.begin(), name.end(), '"', ' ');
  return name;
}

class NvmReader {
 public:
  NvmReader(std::string_view text, const fs::path& path) : numbers_(text, path), path_(path) { take_first_line(); }

  [[nodiscard]] std::vector<NvmModel> models() {
    std::vector<NvmModel> models;
    while (const std::uint64_t cameras = camera_count()) models.push_back(take_model(cameras));
    return models;
  }
  [[nodiscard]] const std::optional<NvmCalibration>& calibration() const { return calibration_; }

 private:
  void take_first_line() {
    const TextRow row = fields_of(numbers_.line());
    if (row.fields.empty() || row.fields.front() != kNvmVersion) {
      throw InputError(path_.string() + ": begins with " +
                       in_quotes(row.fields.empty() ? std::string_view() : row.fields.front()) +
                       ", must be of version " + std::string(kNvmVersion));
    }
    if (row.fields.size() == 1) return;
    if (row.fields[1] != "FixedK") {
      refuse_row(path_, row, "has " + in_quotes(row.fields[1]) + " after NVM_V3, only FixedK is known");
    }
    calibration_ = {number_in(row, 2, path_), number_in(row, 3, path_), number_in(row, 4, path_),
                    number_in(row, 5, path_)};
  }

  [[nodiscard]] TextRow fields_of(std::string_view line) const {
    TextRow row{numbers_.line_number(), {}};
    while (!line.empty()) {
      if (const std::string_view field = take_field(line); !field.empty()) row.fields.push_back(field);
    }
    return row;
  }

  // 0 at the end of the models, which a file that ends there need not state. Comments may follow.
  [[nodiscard]] std::uint64_t camera_count() {
    constexpr std::uint64_t kLeastCameraBytes = 22;  // eleven fields of one character
    if (is_first_) {
      is_first_ = false;
    } else if (numbers_.at_end() || numbers_.next() == '#') {
      return 0;
    }
    return numbers_.count("the number of cameras", kLeastCameraBytes);
  }

  [[nodiscard]] NvmModel take_model(std::uint64_t cameras) {
    constexpr std::uint64_t kLeastPointBytes = 14;  // seven numbers of one digit
    NvmModel model;
    for (std::uint64_t index = 0; index < cameras; ++index) {
      const std::string_view line = numbers_.line();
      if (line.empty()) numbers_.refuse_end("camera " + std::to_string(index));
      model.cameras.push_back(nvm_camera(fields_of(line), path_));
    }
    model.extents.resize(model.cameras.size());
    model.points = numbers_.count("the number of points", kLeastPointBytes);
    for (std::uint64_t point = 0; point < model.points; ++point) take_point(model, "point " + std::to_string(point));
    return model;
  }

  // Position, colour, then where it was measured: camera, number of the feature, x and y.
  void take_point(NvmModel& model, const std::string& point) {
    constexpr std::uint64_t kLeastMeasurementBytes = 8;  // four numbers of one digit
    for (int i = 0; i < 6; ++i) (void)numbers_.number_or_nan(point);
    for (std::uint64_t left = numbers_.count("the number of measurements of " + point, kLeastMeasurementBytes);
         left > 0; --left) {
      const double camera = numbers_.number("the camera of a measurement of " + point);
      (void)numbers_.number_or_nan(point);
      const double x = numbers_.number_or_nan(point), y = numbers_.number_or_nan(point);
      if (!(camera >= 0 && camera < static_cast<double>(model.cameras.size()))) {
        numbers_.refuse(point + " was measured by camera " + number_text(camera) + ", which is not there");
      }
      model.extents[static_cast<std::size_t>(camera)].add(x, y);
    }
  }

  TextNumbers numbers_;
  const fs::path& path_;
  bool is_first_ = true;
  std::optional<NvmCalibration> calibration_;
};

// --- the inverse of the radial term

// q / p for p = q (1 + r q^2), as (1 + k1 p^2 + k2 p^4 + k3 p^6) / (1 + k4 p^2 + k5 p^4 + k6 p^6).
struct InverseRadial {
  std::array<double, 3> above{}, below{};
  double error = std::numeric_limits<double>::infinity();  // the largest of q up to the limit, in units of q

  [[nodiscard]] double ratio(double p2) const {
    const auto series = [&](const std::array<double, 3>& k) { return 1 + p2 * (k[0] + p2 * (k[1] + p2 * k[2])); };
    return series(above) / series(below);
  }
};

void measure_error(InverseRadial& inverse, double r, double limit) {
  constexpr int kSamples = 500;
  inverse.error = 0;
  for (int i = 1; i <= kSamples; ++i) {
    const double q = limit * i / kSamples, p = q * (1 + r * q * q);
    const double error = std::abs(p * inverse.ratio(p * p) - q);
    if (!(error <= inverse.error)) inverse.error = error;  // NaN is kept, and is no error that passes
    if (std::isnan(error)) return;
  }
}

// Solves a linear system of up to six equations in place by elimination with pivots; false if it is singular.
using FitEquation = std::array<double, 7>;  // the last is the right side
bool solve_nvm_fit(std::vector<FitEquation>& rows) {
  const std::size_t n = rows.size();
  for (std::size_t column = 0; column < n; ++column) {
    const auto pivot = std::max_element(
        rows.begin() + static_cast<std::ptrdiff_t>(column), rows.end(),
        [&](const FitEquation& a, const FitEquation& b) { return std::abs(a[column]) < std::abs(b[column]); });
    if ((*pivot)[column] == 0) return false;
    std::swap(rows[column], *pivot);
    for (std::size_t row = 0; row < n; ++row) {
      if (row == column) continue;
      const double factor = rows[row][column] / rows[column][column];
      for (std::size_t i = column; i < 7; ++i) rows[row][i] -= factor * rows[column][i];
    }
  }
  for (std::size_t row = 0; row < n; ++row) rows[row][6] /= rows[row][row];
  return true;
}

// The ratio of two polynomials of this degree that is exact at 0 and at 2 * degree other places up to `limit`, which
// lie densest at its ends, as Chebyshev's nodes do. The inverse is a Stieltjes function of p^2 for r > 0, of which such
// ratios converge fast and without poles.
InverseRadial interpolated(double r, double limit, std::size_t degree) {
  const double farthest = limit * (1 + r * limit * limit), unit = farthest * farthest;
  std::vector<FitEquation> rows(2 * degree);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double angle = std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(rows.size());
    const double q2 = limit * limit * (1 - std::cos(angle)) / 2;
    const double ratio = 1 / (1 + r * q2), p2 = q2 / (ratio * ratio);
    double power = p2 / unit;
    for (std::size_t k = 0; k < degree; ++k, power *= p2 / unit) {
      rows[i][k] = power;
      rows[i][degree + k] = -ratio * power;
    }
    rows[i][6] = ratio - 1;
  }
  InverseRadial inverse;
  if (!solve_nvm_fit(rows)) return inverse;
  double scale = 1 / unit;
  for (std::size_t k = 0; k < degree; ++k, scale /= unit) {
    inverse.above[k] = rows[k][6] * scale;
    inverse.below[k] = rows[degree + k][6] * scale;
  }
  measure_error(inverse, r, limit);
  return inverse;
}

constexpr double kMostErrorPixels = 0.1, kNoErrorPixels = 1e-3;

// The simplest fit up to the measured radius `limit` that is off by less than a thousandth of a pixel, else the best.
InverseRadial inverse_of(double r, double limit, double pixels) {
  InverseRadial best;
  best.above[0] = -r;
  measure_error(best, r, limit);
  for (std::size_t degree = 1; degree <= 3 && !(best.error * pixels < kNoErrorPixels); ++degree) {
    const InverseRadial next = interpolated(r, limit, degree);
    if (!(best.error <= next.error)) best = next;
  }
  return best;
}

// --- cameras

struct NvmLens {
  CameraModel lens;
  double error_px = 0;
};

NvmLens nvm_lens(const NvmCamera& camera, const std::optional<NvmCalibration>& fixed, const ImageSize& size,
                 std::uint32_t scale) {
  NvmLens result;
  const std::uint32_t width = size.width * scale, height = size.height * scale;
  const NvmCalibration k = fixed.value_or(NvmCalibration{camera.f, 0.5 * width, camera.f, 0.5 * height});
  result.lens = {LensModel::kPinhole, width, height, {k.fx, k.fy, k.cx, k.cy}};
  check(result.lens);
  if (camera.r == 0) return result;
  const double limit =
      std::hypot(std::max(k.cx, width - k.cx) / k.fx, std::max(k.cy, height - k.cy) / k.fy);  // the farthest corner
  const double pixels = std::max(k.fx, k.fy);
  if (!(1 + 3 * camera.r * limit * limit > 0)) {
    throw std::invalid_argument("its radial term " + number_text(camera.r) + " turns back inside the photograph");
  }
  const InverseRadial inverse = inverse_of(camera.r, limit, pixels);
  result.error_px = inverse.error * pixels;
  if (!(result.error_px <= kMostErrorPixels)) {
    throw std::invalid_argument("the inverse of its radial term " + number_text(camera.r) +
                                " cannot be fitted within 0.1 pixels: undistort the photographs by VisualSFM's own "
                                "export, or give them in COLMAP's form");
  }
  const std::array<double, 3>&a = inverse.above, &b = inverse.below;
  result.lens.model = LensModel::kFullOpenCv;
  result.lens.parameters = {k.fx, k.fy, k.cx, k.cy, a[0], a[1], 0, 0, a[2], b[0], b[1], b[2]};
  check(result.lens);
  return result;
}

// Returns the model with the most cameras among those with points, or among all models if none has points.
const NvmModel& model_to_read(const std::vector<NvmModel>& models) {
  return *std::max_element(models.begin(), models.end(), [](const NvmModel& a, const NvmModel& b) {
    return std::pair(a.points > 0, a.cameras.size()) < std::pair(b.points > 0, b.cameras.size());
  });
}

void set_nvm_pose(PosedPhotograph& photograph, const NvmCamera& camera, const TextRow& row, const fs::path& path) {
  constexpr double kMostOff = 0.01;  // six digits are written
  const double length = glm::length(camera.q);
  if (!(std::abs(length - 1) <= kMostOff)) {
    refuse_row(path, row, "its quaternion has the length " + number_text(length) + ", must be 1");
  }
  const glm::dmat3 cam_from_world = glm::mat3_cast(glm::normalize(camera.q));
  const std::string broken =
      set_pose(photograph, glm::transpose(cam_from_world), camera.center, CameraAxes::right_down_forward);
  if (!broken.empty()) refuse_row(path, row, "its pose " + broken);
}

void check_fixed(const NvmCamera& camera, const NvmCalibration& fixed, const TextRow& row, const fs::path& path) {
  constexpr double kMostOff = 1e-3;  // six digits are written
  if (std::abs(camera.f - fixed.fx) <= kMostOff * std::abs(fixed.fx)) return;
  refuse_row(
      path, row,
      "has the focal length " + number_text(camera.f) + ", but the first line fixes it to " + number_text(fixed.fx));
}

template <typename Read>
void refuse_or_keep_nvm(PosedPhotograph& photograph, BadPhotographs bad, const Read& read) {
  try {
    read();
  } catch (const InputError& error) {
    if (bad == BadPhotographs::refuse) throw;
    if (photograph.bad.empty()) photograph.bad = error.what();
  }
}

// Notes the models that are left out, and how many photographs they have.
void note_other_models(Capture& posed, const std::vector<NvmModel>& models, const NvmModel& read) {
  std::size_t others = 0, in_others = 0, without_pose = 0;
  for (const NvmModel& model : models) {
    if (&model == &read) continue;
    if (model.points == 0 && read.points > 0) {
      without_pose += model.cameras.size();
    } else {
      ++others;
      in_others += model.cameras.size();
    }
  }
  note_skipped(posed, without_pose, "have no pose");
  if (others == 0) return;
  posed.left_out += in_others;
  posed.notes.push_back("of " + std::to_string(others + 1) +
                        " models, which are not in one coordinate system, the one "
                        "with the most cameras is read, " +
                        std::to_string(read.cameras.size()) + "; " + std::to_string(in_others) +
                        " cameras of the others are left out");
}

}  // namespace

Capture parse_visual_sfm(std::string_view text, const fs::path& path, const PhotographLookup& photographs) {
  NvmReader reader(text, path);
  const std::vector<NvmModel> models = reader.models();
  if (models.empty()) throw InputError(path.string() + ": has no model with cameras, so there is nothing to see");
  const NvmModel& model = model_to_read(models);
  const std::optional<NvmCalibration>& fixed = reader.calibration();
  Capture posed;
  std::vector<ImageSize> sizes;
  for (const NvmCamera& camera : model.cameras) {
    const TextRow row{camera.line, {}};
    PosedPhotograph& photograph = posed.photographs.emplace_back(photographs.find(nvm_name(camera.name)));
    refuse_or_keep_nvm(photograph, photographs.bad, [&] {
      if (fixed) check_fixed(camera, *fixed, row, path);
      set_nvm_pose(photograph, camera, row, path);
    });
    sizes.push_back(photographs.size_of(photograph));
  }
  const std::uint32_t scale = measured_scale(model.extents, sizes, path);
  double worst_px = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    PosedPhotograph& photograph = posed.photographs[i];
    refuse_or_keep_nvm(photograph, photographs.bad, [&] {
      try {
        const NvmLens fitted = nvm_lens(model.cameras[i], fixed, sizes[i], scale);
        photograph.lens = fitted.lens;
        worst_px = std::max(worst_px, fitted.error_px);
      } catch (const std::invalid_argument& error) {
        refuse_row(path, {model.cameras[i].line, {}}, std::string("an impossible camera: ") + error.what());
      }
    });
  }
  note_other_models(posed, models, model);
  finish(posed, path, photographs.bad);
  posed.notes.push_back(measured_scale_note(scale, path) +
                        (fixed ? "" : ", and their middles are taken to be the principal points"));
  if (worst_px >= kNoErrorPixels) {
    posed.notes.push_back("the inverse of VisualSFM's radial term is fitted within " + number_text(worst_px, 3) +
                          " pixels");
  }
  return posed;
}

std::optional<fs::path> find_visual_sfm(const fs::path& scene) {
  for (const fs::path& file : files_ending_in(scene, ".nvm")) {
    if (first_bytes(file).starts_with(kNvmStart)) return file;
  }
  return std::nullopt;
}

Capture read_visual_sfm(const CaptureRequest& request) {
  const fs::path path = find_visual_sfm(request.scene).value();
  PhotographLookup lookup = photographs_of(request);
  // VisualSFM names photographs from its working folder on: the file's name is what is left of it here.
  lookup.find = [find = lookup.find](std::string_view name) { return find(name_without(fs::path(name), "images")); };
  return parse_visual_sfm(read_whole_file(path), path, lookup);
}

}  // namespace lumatlas
