// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/transforms_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/base/strict_json.h"
#include "tools/scene/forms/lens_coefficients.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

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

// What is read, of a frame or of the whole file, beside the coefficients.
constexpr auto kReadKeys = std::to_array<std::string_view>(
    {"frames", "file_path", "mask_path", "depth_file_path", "depth_unit_scale_factor", "applied_scale",
     "applied_transform", "transform_matrix", "ply_file_path", "w", "h", "fl_x", "fl_y", "cx", "cy", "camera_angle_x",
     "camera_angle_y", "camera_model", "is_fisheye"});

// What changes nothing about these poses, lenses and pictures: how a program is to train, what it is to do to poses
// first, what it found out on the way, and when.
constexpr auto kKeysOfNoConcern = std::to_array<std::string_view>({"aabb",
                                                                   "aabb_scale",
                                                                   "bounding_box",
                                                                   "camera_id",
                                                                   "camera_label",
                                                                   "colmap_im_id",
                                                                   "colmap_image_id",
                                                                   "cam_id",
                                                                   "id",
                                                                   "index",
                                                                   "name",
                                                                   "frame_id",
                                                                   "sharpness",
                                                                   "sharpness_discard_threshold",
                                                                   "blur_score",
                                                                   "motion_blur",
                                                                   "timestamp",
                                                                   "time",
                                                                   "train_filenames",
                                                                   "val_filenames",
                                                                   "test_filenames",
                                                                   "train_split",
                                                                   "n_extra_learnable_dims",
                                                                   "up",
                                                                   "near",
                                                                   "far",
                                                                   "version",
                                                                   "created",
                                                                   "orientation_override",
                                                                   "auto_scale_poses_override",
                                                                   "scale",
                                                                   "offset",
                                                                   "from_na"});

template <typename Words>
bool is_in(std::string_view word, const Words& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

enum class Bending { perspective, full_opencv, fisheye };

std::span<const std::string_view> coefficients_of(Bending bending) {
  static constexpr auto kAll = std::to_array<std::string_view>({"k1", "k2", "k3", "k4", "p1", "p2", "k5", "k6"});
  switch (bending) {
    case Bending::fisheye:
      return std::span(kAll).first(4);
    case Bending::perspective:
      return std::span(kAll).first(6);
    case Bending::full_opencv:
      break;
  }
  return kAll;
}

// nerfstudio's names, which are COLMAP's. It reads the same coefficients for all that are not fisheyes.
Bending bending_of(const Settings& settings) {
  constexpr std::array kPerspective{"SIMPLE_PINHOLE"sv, "PINHOLE"sv, "SIMPLE_RADIAL"sv, "RADIAL"sv, "OPENCV"sv};
  const auto fisheye = settings.find("is_fisheye");
  const bool is_fisheye = fisheye && fisheye->boolean();
  const auto place = settings.find("camera_model");
  if (!place) return is_fisheye ? Bending::fisheye : Bending::perspective;
  const std::string model = place->text();
  if (model == "OPENCV_FISHEYE") return Bending::fisheye;
  if (model == "EQUIRECTANGULAR") {
    place->refuse("is EQUIRECTANGULAR, but no plane holds a panorama: cut it into pinhole views");
  }
  if (model != "FULL_OPENCV" && !is_in(model, kPerspective)) {
    place->refuse("is " + in_quotes(model) +
                  ", which this program does not read: undistort the photographs, or use SIMPLE_PINHOLE, PINHOLE, "
                  "SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV or OPENCV_FISHEYE");
  }
  if (is_fisheye) place->refuse("is " + in_quotes(model) + ", but is_fisheye is true: keep one of them");
  return model == "FULL_OPENCV" ? Bending::full_opencv : Bending::perspective;
}

double focal_length(const Settings& settings, const char* length, const char* angle, std::uint32_t size,
                    std::optional<double> otherwise) {
  if (const auto given = settings.number(length)) return *given;
  if (const auto radians = settings.number(angle)) return 0.5 * size / std::tan(0.5 * *radians);
  if (otherwise) return *otherwise;
  settings.frame().refuse("has no focal length, must have fl_x or camera_angle_x, or the whole file must");
}

// The simplest model that has all of the coefficients.
CameraModel bent_lens(const Settings& settings, const BrownLens& pinhole) {
  const Bending bending = bending_of(settings);
  refuse_unread_coefficients([&](std::string_view key) { return settings.find(key); }, coefficients_of(bending),
                             bending == Bending::fisheye ? " of a fisheye" : "");
  const auto k = [&](const char* key) { return settings.number_or(key, 0); };
  if (bending == Bending::perspective) {
    BrownLens brown = pinhole;
    brown.k1 = k("k1");
    brown.k2 = k("k2");
    brown.k3 = k("k3");
    brown.k4 = k("k4");
    brown.p1 = k("p1");
    brown.p2 = k("p2");
    return lens_of(brown);
  }
  CameraModel lens = lens_of(pinhole);
  const auto set = [&](LensModel model, std::initializer_list<double> coefficients) {
    lens.model = model;
    std::copy(coefficients.begin(), coefficients.end(), lens.parameters.begin() + 4);
  };
  if (bending == Bending::fisheye) {
    set(LensModel::kOpenCvFisheye, {k("k1"), k("k2"), k("k3"), k("k4")});
  } else {
    set(LensModel::kFullOpenCv, {k("k1"), k("k2"), k("p1"), k("p2"), k("k3"), k("k4"), k("k5"), k("k6")});
  }
  check(lens);
  return lens;
}

CameraModel lens_of(const Settings& settings, const PosedPhotograph& frame,
                    const std::function<ImageSize(const PosedPhotograph&)>& size_of) {
  BrownLens lens;
  const auto width = settings.size("w"), height = settings.size("h");
  if (width && height) {
    lens.width = *width;
    lens.height = *height;
  } else {
    const ImageSize size = size_of(frame);
    lens.width = width.value_or(size.width);
    lens.height = height.value_or(size.height);
  }
  lens.fx = focal_length(settings, "fl_x", "camera_angle_x", lens.width, std::nullopt);
  lens.fy = focal_length(settings, "fl_y", "camera_angle_y", lens.height, lens.fx);
  lens.cx = settings.number_or("cx", 0.5 * lens.width);
  lens.cy = settings.number_or("cy", 0.5 * lens.height);
  try {
    return bent_lens(settings, lens);
  } catch (const std::invalid_argument& error) {
    settings.frame().refuse(std::string("has a camera that cannot be: ") + error.what());
  }
}

void check_bottom(const JsonPlace& matrix, const JsonPlace& row) {
  const std::vector<JsonPlace> values = row.elements();
  if (values.size() != 4) row.refuse("must have 4 numbers");
  try {
    check_last_row({values[0].number(), values[1].number(), values[2].number(), values[3].number()});
  } catch (const std::invalid_argument& error) {
    matrix.refuse(error.what());
  }
}

void set_pose(const JsonPlace& place, PosedPhotograph& frame) {
  const std::vector<JsonPlace> rows = place.elements();
  if (rows.size() != 3 && rows.size() != 4) {
    place.refuse("has " + std::to_string(rows.size()) + " rows, must have 4, or 3 without the last");
  }
  if (rows.size() == 4) check_bottom(place, rows[3]);
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

// Remembers keys that the lists above do not have.
void collect_unknown(const JsonPlace& object, std::set<std::string>& unknown) {
  for (const auto& [key, value] : object.value().items()) {
    if (is_in(key, kReadKeys) || is_in(key, kKeysOfNoConcern) || is_lens_coefficient(key)) continue;
    unknown.insert(key);
  }
}

void note_unknown(const std::set<std::string>& unknown, const fs::path& path, Capture& posed) {
  if (unknown.empty()) return;
  constexpr std::size_t kMostNamed = 10;
  std::string names;
  std::size_t named = 0;
  for (const std::string& key : unknown) {
    if (++named > kMostNamed) break;
    names += (names.empty() ? "" : ", ") + short_reason(key);
  }
  posed.notes.push_back(
      path.filename().string() + " has keys that are not known and not used: " + names +
      (unknown.size() > kMostNamed ? ", and " + std::to_string(unknown.size() - kMostNamed) + " more" : ""));
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

Capture parse_transforms(std::string_view text, const fs::path& path,
                         const std::function<fs::path(const fs::path&)>& complete,
                         const std::function<ImageSize(const PosedPhotograph&)>& size_of) {
  const nlohmann::json content = parse_json(text, path.string());
  const JsonPlace all(path.string(), "", content);
  if (!content.is_object() || !all.has("frames")) throw InputError(path.string() + ": has no list of frames");
  Capture result;
  std::set<std::string> unknown;
  collect_unknown(all, unknown);
  for (const JsonPlace& place : all.at("frames").elements()) {
    if (!place.value().is_object() || !place.has("file_path") || !place.has("transform_matrix")) {
      place.refuse("must have file_path and transform_matrix");
    }
    collect_unknown(place, unknown);
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
  note_unknown(unknown, path, result);
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

Capture read_transforms(const fs::path& scene, const std::optional<fs::path>& images) {
  const fs::path path = scene / "transforms.json";
  return parse_transforms(
      read_whole_file(path), path, [&](const fs::path& file) { return with_ending(scene, file); },
      sizes_in(scene, images));
}

}  // namespace lumatlas
