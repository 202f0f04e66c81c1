// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/transforms_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
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
#include "tools/scene/forms/fields/brown_lens.h"
#include "tools/scene/forms/fields/lens_coefficients.h"
#include "tools/scene/forms/fields/unknown_keys.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

// Returns the path that a frame names, with '/' between folders; it may lead out of the scene's folder.
fs::path named_path(const JsonPlace& place) {
  std::string text = place.text();
  std::replace(text.begin(), text.end(), '\\', '/');
  return inner_path(text).value_or(fs::path(text).lexically_normal());
}

fs::path path_in(const JsonPlace& place, const TransformsLookup& lookup) {
  const fs::path named = named_path(place);
  if (const std::optional<fs::path> path = inner_path(lookup.complete(named).string())) return *path;
  place.refuse("is " + in_quotes(named.string()) + ", and no end of this path is a file in the folder of this one");
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

// The keys that are read, in a frame or in the whole file, beside the coefficients.
constexpr auto kReadKeys = std::to_array<std::string_view>({"frames",
                                                            "file_path",
                                                            "mask_path",
                                                            "depth_file_path",
                                                            "depth_unit_scale_factor",
                                                            "applied_scale",
                                                            "applied_transform",
                                                            "transform_matrix",
                                                            "ply_file_path",
                                                            "w",
                                                            "h",
                                                            "fl_x",
                                                            "fl_y",
                                                            "cx",
                                                            "cy",
                                                            "camera_angle_x",
                                                            "camera_angle_y",
                                                            "camera_model",
                                                            "is_fisheye",
                                                            "train_filenames",
                                                            "val_filenames",
                                                            "test_filenames"});

// The keys that change nothing about these poses, lenses and pictures: how a program should train, what it should do to
// poses first, what it found out on the way, and when.
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
                                                                   "rotation",
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

enum class Bending { perspective, full_opencv, fisheye, panorama };

std::span<const std::string_view> coefficients_of(Bending bending) {
  static constexpr auto kAll = std::to_array<std::string_view>({"k1", "k2", "k3", "k4", "p1", "p2", "k5", "k6"});
  switch (bending) {
    case Bending::fisheye:
      return std::span(kAll).first(4);
    case Bending::perspective:
      return std::span(kAll).first(6);
    case Bending::panorama:
      return {};
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
  if (model == "EQUIRECTANGULAR") return Bending::panorama;
  if (model != "FULL_OPENCV" && !is_in(model, kPerspective)) {
    place->refuse("is " + in_quotes(model) +
                  ", which this program does not read: undistort the photographs, or use SIMPLE_PINHOLE, PINHOLE, "
                  "SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, OPENCV_FISHEYE or EQUIRECTANGULAR");
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

CameraModel panorama(const Settings& settings, std::uint32_t width, std::uint32_t height) {
  refuse_unread_coefficients([&](std::string_view key) { return settings.find(key); },
                             coefficients_of(Bending::panorama), " of a panorama");
  return {LensModel::kEquirectangular, width, height, {static_cast<double>(width), static_cast<double>(height)}};
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
  if (bending_of(settings) == Bending::panorama) return panorama(settings, lens.width, lens.height);
  lens.fx = focal_length(settings, "fl_x", "camera_angle_x", lens.width, std::nullopt);
  lens.fy = focal_length(settings, "fl_y", "camera_angle_y", lens.height, lens.fx);
  lens.cx = settings.number_or("cx", 0.5 * lens.width);
  lens.cy = settings.number_or("cy", 0.5 * lens.height);
  try {
    return bent_lens(settings, lens);
  } catch (const std::invalid_argument& error) {
    settings.frame().refuse(std::string("has an impossible camera: ") + error.what());
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

bool is_known_key(std::string_view key) {
  return is_in(key, kReadKeys) || is_in(key, kKeysOfNoConcern) || is_lens_coefficient(key);
}

PosedPhotograph read_frame(const JsonPlace& place, const JsonPlace& all, const TransformsLookup& lookup) {
  if (!place.has("file_path") || !place.has("transform_matrix")) {
    place.refuse("must have file_path and transform_matrix");
  }
  PosedPhotograph frame;
  frame.file = lookup.complete(named_path(place.at("file_path")));
  frame.name = name_without(frame.file, "images");
  if (place.has("mask_path")) frame.mask = path_in(place.at("mask_path"), lookup);
  frame.lens = lens_of(Settings(place, all), frame, lookup.size_of);
  set_pose(place.at("transform_matrix"), frame);
  return frame;
}

// The file that a frame names, for one that cannot be read.
std::string name_of(const JsonPlace& frame, std::size_t index) {
  const bool named = frame.has("file_path") && frame.at("file_path").value().is_string();
  return named ? name_without(named_path(frame.at("file_path")), "images") : "frames[" + std::to_string(index) + "]";
}

void read_frames(const JsonPlace& all, const TransformsLookup& lookup, Capture& result) {
  std::size_t index = 0;
  for (const JsonPlace& place : all.at("frames").elements()) {
    if (!place.value().is_object()) place.refuse("must be an object with file_path and transform_matrix");
    add_photograph(result, lookup.bad, name_of(place, index++), [&] { return read_frame(place, all, lookup); });
    const PosedPhotograph& frame = result.photographs.back();
    if (!frame.bad.empty() || !place.has("depth_file_path")) continue;
    result.depths.push_back(
        depth_with(frame, path_in(place.at("depth_file_path"), lookup), depth_unit(Settings(place, all))));
  }
}

// nerfstudio's lists of files: those to score, else those that are looked at while training.
void read_lists(const JsonPlace& all, const std::string& file, Capture& result) {
  for (const char* const key : {"test_filenames", "val_filenames"}) {
    if (!all.has(key)) continue;
    std::vector<std::string> paths;
    for (const JsonPlace& place : all.at(key).elements()) paths.push_back(named_path(place).string());
    if (paths.empty()) continue;
    return hold_out(result, paths, std::string(key) + " of " + file);
  }
}

// The file that is there, of one that may lack its ending, as in NeRF's own files, or that is named by a path of
// another computer; the path itself if there is none.
fs::path completed(const fs::path& scene, const fs::path& file) {
  constexpr std::array kEndings{"", ".png", ".jpg", ".jpeg", ".JPG"};
  std::error_code ignored;
  for (const char* const ending : kEndings) {
    const std::optional<fs::path> candidate = inner_path(file.string() + ending);
    if (candidate && fs::exists(scene / *candidate, ignored)) return *candidate;
  }
  return file;
}

// The first of Blender's files with photographs to score, if there is one.
std::optional<fs::path> file_to_score(const fs::path& scene) {
  std::error_code ignored;
  for (const char* const name : {"transforms_test.json", "transforms_val.json"}) {
    if (fs::exists(scene / name, ignored)) return scene / name;
  }
  return std::nullopt;
}

void add_photographs_to_score(const fs::path& path, const CaptureRequest& request, const TransformsLookup& lookup,
                              Capture& capture) {
  Capture other = parse_transforms(read_whole_file(path), path, lookup);
  for (PosedPhotograph& photograph : other.photographs) {
    photograph.held_out = true;
    photograph.named_by = path.string();
    photograph.sized_by = "its camera in " + path.string();
  }
  capture.notes.push_back(std::to_string(other.photographs.size()) + " photographs are for scoring alone, as " +
                          path.string() + " says");
  std::move(other.photographs.begin(), other.photographs.end(), std::back_inserter(capture.photographs));
  finish(capture, request.scene, request.bad);
}

}  // namespace

Capture parse_transforms(std::string_view text, const fs::path& path, const TransformsLookup& lookup) {
  const nlohmann::json content = parse_json_with_nan(text, path.string());
  const JsonPlace all(path.string(), "", content);
  if (!content.is_object() || !all.has("frames")) throw InputError(path.string() + ": has no list of frames");
  UnknownKeys unknown;
  unknown.look_at(all, is_known_key);
  Capture result;
  read_frames(all, lookup, result);
  for (const JsonPlace& frame : all.at("frames").elements()) unknown.look_at(frame, is_known_key);
  if (all.has("ply_file_path")) result.points = path_in(all.at("ply_file_path"), lookup);
  finish(result, path, lookup.bad);
  read_lists(all, path.filename().string(), result);
  unknown.tell(path, result);
  if (!result.depths.empty()) {
    note_depths(result, "a step of the first taken to be " + number_text(result.depths.front().unit) +
                            " units, and each to show what its photograph shows");
  }
  return result;
}

std::optional<fs::path> find_transforms(const fs::path& scene) {
  std::error_code ignored;
  for (const char* const name : {"transforms.json", "transforms_train.json"}) {
    if (fs::exists(scene / name, ignored)) return scene / name;
  }
  return std::nullopt;
}

Capture read_transforms(const CaptureRequest& request) {
  const fs::path path = find_transforms(request.scene).value();
  const TransformsLookup lookup{[&](const fs::path& file) { return completed(request.scene, file); },
                                sizes_in(request.scene, request.images), request.bad};
  Capture capture = parse_transforms(read_whole_file(path), path, lookup);
  if (path.filename() == "transforms.json") return capture;
  if (const std::optional<fs::path> other = file_to_score(request.scene)) {
    add_photographs_to_score(*other, request, lookup, capture);
  }
  return capture;
}

}  // namespace lumatlas
