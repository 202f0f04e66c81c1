// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/transforms_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/base/strict_json.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

fs::path path_in(const JsonPlace& place) {
  const std::string text = place.text();
  if (const std::optional<fs::path> path = inner_path(text)) return *path;
  place.refuse("is " + in_quotes(text) + ", must be a path to a file in the folder of this one");
}

// A frame's own value, else that of all frames.
class Settings {
 public:
  Settings(JsonPlace frame, JsonPlace all) : frame_(std::move(frame)), all_(std::move(all)) {}

  [[nodiscard]] std::optional<JsonPlace> find(std::string_view key) const {
    if (frame_.has(key)) return frame_.at(key);
    if (all_.has(key)) return all_.at(key);
    return std::nullopt;
  }
  [[nodiscard]] std::optional<double> number(std::string_view key) const {
    const std::optional<JsonPlace> place = find(key);
    return place ? std::optional(place->number()) : std::nullopt;
  }
  [[nodiscard]] double number_or(std::string_view key, double otherwise) const {
    return number(key).value_or(otherwise);
  }
  // Some programs write sizes as 640.0.
  [[nodiscard]] std::optional<std::uint32_t> size(std::string_view key) const {
    const std::optional<JsonPlace> place = find(key);
    if (!place) return std::nullopt;
    const double value = place->number();
    if (!(value >= 1 && value <= 65536) || value != std::floor(value)) {
      place->refuse("is " + number_text(value) + ", must be a whole number in [1, 65536]");
    }
    return static_cast<std::uint32_t>(value);
  }
  [[nodiscard]] const JsonPlace& frame() const { return frame_; }

 private:
  JsonPlace frame_, all_;
};

bool is_fisheye(const Settings& settings) {
  if (const auto model = settings.find("camera_model")) return model->text() == "OPENCV_FISHEYE";
  const auto fisheye = settings.find("is_fisheye");
  return fisheye && fisheye->boolean();
}

double focal_length(const Settings& settings, const char* length, const char* angle, std::uint32_t size,
                    std::optional<double> otherwise) {
  if (const auto given = settings.number(length)) return *given;
  if (const auto radians = settings.number(angle)) return 0.5 * size / std::tan(0.5 * *radians);
  if (otherwise) return *otherwise;
  settings.frame().refuse("has no focal length, must have fl_x or camera_angle_x, or the whole file must");
}

// The simplest of COLMAP's models that has all of the coefficients.
void set_distortion(const Settings& settings, CameraModel& lens) {
  const auto k = [&](const char* key) { return settings.number_or(key, 0); };
  const std::array<double, 6> c{k("k1"), k("k2"), k("p1"), k("p2"), k("k3"), k("k4")};
  const auto set = [&](LensModel model, std::initializer_list<double> coefficients) {
    lens.model = model;
    std::copy(coefficients.begin(), coefficients.end(), lens.parameters.begin() + 4);
  };
  if (is_fisheye(settings)) {
    set(LensModel::kOpenCvFisheye, {c[0], c[1], c[4], c[5]});
  } else if (c[4] != 0 || c[5] != 0) {
    set(LensModel::kFullOpenCv, {c[0], c[1], c[2], c[3], c[4], c[5], 0, 0});
  } else if (c != std::array<double, 6>{}) {
    set(LensModel::kOpenCv, {c[0], c[1], c[2], c[3]});
  }
}

CameraModel lens_of(const Settings& settings, const PosedPhotograph& frame,
                    const std::function<ImageSize(const PosedPhotograph&)>& size_of) {
  CameraModel lens;
  const auto width = settings.size("w"), height = settings.size("h");
  if (width && height) {
    lens.width = *width;
    lens.height = *height;
  } else {
    const ImageSize size = size_of(frame);
    lens.width = width.value_or(size.width);
    lens.height = height.value_or(size.height);
  }
  const double fx = focal_length(settings, "fl_x", "camera_angle_x", lens.width, std::nullopt);
  const double fy = focal_length(settings, "fl_y", "camera_angle_y", lens.height, fx);
  lens.parameters = {fx, fy, settings.number_or("cx", 0.5 * lens.width), settings.number_or("cy", 0.5 * lens.height)};
  if (const auto model = settings.find("camera_model"); model && model->text() == "EQUIRECTANGULAR") {
    model->refuse("is EQUIRECTANGULAR, but no plane holds a panorama: cut it into pinhole views");
  }
  set_distortion(settings, lens);
  try {
    check(lens);
  } catch (const std::invalid_argument& error) {
    settings.frame().refuse(std::string("has a camera that cannot be: ") + error.what());
  }
  return lens;
}

void set_pose(const JsonPlace& place, PosedPhotograph& frame) {
  const std::vector<JsonPlace> rows = place.elements();
  if (rows.size() != 3 && rows.size() != 4) {
    place.refuse("has " + std::to_string(rows.size()) + " rows, must have 4, or 3 without the last");
  }
  glm::dmat3 world_from_gl(1);
  glm::dvec3 center(0);
  for (int row = 0; row < 3; ++row) {
    const std::vector<JsonPlace> values = rows[static_cast<std::size_t>(row)].elements();
    if (values.size() != 4) rows[static_cast<std::size_t>(row)].refuse("must have 4 numbers");
    for (int column = 0; column < 3; ++column) {
      world_from_gl[column][row] = values[static_cast<std::size_t>(column)].number();
    }
    center[row] = values[3].number();
  }
  const std::string broken = set_pose(frame, world_from_gl, center, CameraAxes::right_up_backward);
  if (!broken.empty()) place.refuse(broken);
}

// World units of one step.
double depth_unit(const Settings& settings) {
  double unit = 0.001;  // nerfstudio's default
  for (const char* const key : {"depth_unit_scale_factor", "applied_scale"}) {
    const std::optional<JsonPlace> place = settings.find(key);
    if (!place) continue;
    const double factor = place->number();
    if (!(factor >= 1e-9 && factor <= 1e9)) place->refuse("is " + number_text(factor) + ", must be in [1e-9, 1e9]");
    unit = std::string_view(key) == "applied_scale" ? unit * factor : factor;
  }
  return unit;
}

// NeRF's own files leave the ending out.
fs::path with_ending(const fs::path& folder, const fs::path& file) {
  std::error_code ignored;
  if (fs::exists(folder / file, ignored)) return file;
  for (const char* const ending : {".png", ".jpg", ".jpeg", ".JPG"}) {
    fs::path candidate = file;
    candidate += ending;
    if (fs::exists(folder / candidate, ignored)) return candidate;
  }
  return file;
}

}  // namespace

PosedPhotographs parse_transforms(std::string_view text, const fs::path& path,
                                  const std::function<fs::path(const fs::path&)>& complete,
                                  const std::function<ImageSize(const PosedPhotograph&)>& size_of) {
  const nlohmann::json content = parse_json(text, path.string());
  const JsonPlace all(path.string(), "", content);
  if (!content.is_object() || !all.has("frames")) throw InputError(path.string() + ": has no list of frames");
  PosedPhotographs result;
  for (const JsonPlace& place : all.at("frames").elements()) {
    if (!place.value().is_object() || !place.has("file_path") || !place.has("transform_matrix")) {
      place.refuse("must have file_path and transform_matrix");
    }
    PosedPhotograph frame;
    frame.file = complete(path_in(place.at("file_path")));
    frame.name = name_without(frame.file, "images");
    if (place.has("mask_path")) frame.mask = path_in(place.at("mask_path"));
    frame.lens = lens_of(Settings(place, all), frame, size_of);
    set_pose(place.at("transform_matrix"), frame);
    if (place.has("depth_file_path")) {
      result.depths.push_back(
          depth_with(frame, path_in(place.at("depth_file_path")), depth_unit(Settings(place, all))));
    }
    result.photographs.push_back(std::move(frame));
  }
  if (all.has("ply_file_path")) result.points = path_in(all.at("ply_file_path"));
  finish(result, path);
  if (!result.depths.empty()) {
    note_depths(result, "a step of the first taken to be " + number_text(result.depths.front().unit) +
                            " units, and each to show what its photograph shows");
  }
  return result;
}

std::optional<fs::path> find_transforms(const fs::path& scene) {
  std::error_code ignored;
  const fs::path path = scene / "transforms.json";
  return fs::exists(path, ignored) ? std::optional(path) : std::nullopt;
}

PosedPhotographs read_transforms(const fs::path& scene, const std::optional<fs::path>& images) {
  const fs::path path = scene / "transforms.json";
  return parse_transforms(
      read_whole_file(path), path, [&](const fs::path& file) { return with_ending(scene, file); },
      sizes_in(scene, images));
}

}  // namespace lumatlas
