// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/scannet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <system_error>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/scene/forms/fields/brown_lens.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

using Matrix = std::array<double, 16>;  // rows one after the other

// Infinite values and those that are no numbers are taken too.
Matrix matrix_of(std::string_view text, const fs::path& path) {
  constexpr std::string_view kBlanks = " \t\r\v\f\n";
  Matrix matrix;
  for (std::size_t i = 0; i < matrix.size(); ++i) {
    const std::string_view field = take_field(text, kBlanks);
    const std::optional<double> number = parse_number(field);
    if (!number) {
      throw InputError(path.string() + ": value " + std::to_string(i) + " of 16 is " + in_quotes(field) +
                       ", must be a number");
    }
    matrix[i] = *number;
  }
  if (!take_field(text, kBlanks).empty()) throw InputError(path.string() + ": has more than 16 values");
  return matrix;
}

bool is_lost(const Matrix& m) {
  return std::any_of(m.begin(), m.end(), [](double x) { return !std::isfinite(x); });
}

void check_pose_matrix(const Matrix& m, const fs::path& path) {
  try {
    check_last_row({m[12], m[13], m[14], m[15]});
  } catch (const std::invalid_argument& error) {
    throw InputError(path.string() + ": " + error.what());
  }
}

// The matrix has only these five numbers, beside 1 in its third and fourth row.
void check_only_lens(const Matrix& m, const fs::path& path) {
  constexpr double kMostRounding = 1e-6;
  for (std::size_t i = 0; i < m.size(); ++i) {
    if (i == 0 || i == 1 || i == 2 || i == 5 || i == 6) continue;
    const double expected = i == 10 || i == 15 ? 1 : 0;
    if (std::abs(m[i] - expected) <= kMostRounding) continue;
    throw InputError(path.string() + ": value " + std::to_string(i) + " of 16 is " + number_text(m[i]) + ", must be " +
                     number_text(expected) + ": rows are fx skew cx 0, 0 fy cy 0, 0 0 1 0 and 0 0 0 1");
  }
}

CameraModel lens_of_matrix(const Matrix& m, const ImageSize& size, const fs::path& path) {
  check_only_lens(m, path);
  constexpr double kHalfPixel = 0.5;  // from the middle of the first pixel to its corner
  BrownLens lens{size.width, size.height, m[0], m[5], m[2] + kHalfPixel, m[6] + kHalfPixel};
  lens.skew = m[1];
  try {
    return lens_of(lens);
  } catch (const std::invalid_argument& error) {
    throw InputError(path.string() + ": an impossible camera: " + error.what());
  }
}

fs::path pose_file(const fs::path& folder, const std::string& name) {
  return folder / "pose" / (fs::path(name).stem().string() + ".txt");
}

void add_depths(const ScanNetFiles& files, Capture& posed) {
  constexpr double kUnit = 0.001;
  const ScanNetDepths& depths = *files.depths;
  const fs::path path = files.folder / "intrinsic" / "intrinsic_depth.txt";
  std::optional<CameraModel> lens;
  if (depths.intrinsic) lens = lens_of_matrix(matrix_of(*depths.intrinsic, path), depths.size, path);
  for (const PosedPhotograph& photograph : posed.photographs) {
    const std::string stem = fs::path(photograph.name).stem().string();
    if (!depths.stems.contains(stem)) continue;
    posed.depths.push_back(depth_with(photograph, fs::path("depth") / (stem + ".png"), kUnit));
    if (lens) posed.depths.back().lens = *lens;
  }
  note_depths(posed, "taken to be in millimetres, from the photographs' poses, by " +
                         std::string(lens ? "the lens of intrinsic_depth.txt" : "the photographs' lens"));
}

std::optional<ScanNetDepths> depths_in(const fs::path& scene) {
  const std::vector<fs::path> found = files_ending_in(scene / "depth", ".png");
  if (found.empty()) return std::nullopt;
  ScanNetDepths depths{{}, std::nullopt, photograph_size(found.front(), Orientation::as_stored)};
  for (const fs::path& file : found) depths.stems.insert(file.stem().string());
  const fs::path intrinsic = scene / "intrinsic" / "intrinsic_depth.txt";
  std::error_code ignored;
  if (fs::exists(intrinsic, ignored)) depths.intrinsic = read_whole_file(intrinsic);
  return depths;
}

}  // namespace

Capture parse_scannet(const ScanNetFiles& files, const std::function<ImageSize(const PosedPhotograph&)>& size_of) {
  Capture posed;
  std::size_t lost = 0;
  for (const auto& [name, text] : files.poses) {
    const fs::path path = pose_file(files.folder, name);
    const Matrix m = matrix_of(text, path);
    if (is_lost(m)) {
      ++lost;
      continue;
    }
    check_pose_matrix(m, path);
    PosedPhotograph photograph{name, fs::path("color") / name};
    glm::dmat3 world_from_camera;
    for (int i = 0; i < 9; ++i) world_from_camera[i % 3][i / 3] = m[static_cast<std::size_t>(4 * (i / 3) + i % 3)];
    const std::string broken =
        set_pose(photograph, world_from_camera, {m[3], m[7], m[11]}, CameraAxes::right_down_forward);
    if (!broken.empty()) throw InputError(path.string() + ": " + broken);
    posed.photographs.push_back(std::move(photograph));
  }
  note_skipped(posed, lost, "have a pose that is not finite");
  finish(posed, files.folder / "pose");
  const fs::path path = files.folder / "intrinsic" / "intrinsic_color.txt";
  const CameraModel lens = lens_of_matrix(matrix_of(files.intrinsic, path), size_of(posed.photographs.front()), path);
  for (PosedPhotograph& photograph : posed.photographs) photograph.lens = lens;
  if (files.depths) add_depths(files, posed);
  return posed;
}

std::optional<fs::path> find_scannet(const fs::path& scene) {
  std::error_code ignored;
  const fs::path intrinsic = scene / "intrinsic" / "intrinsic_color.txt";
  const bool is_one = fs::exists(intrinsic, ignored) && fs::is_directory(scene / "pose", ignored);
  return is_one ? std::optional(intrinsic) : std::nullopt;
}

Capture read_scannet(const CaptureRequest& request) {
  ScanNetFiles files{request.scene, read_whole_file(request.scene / "intrinsic" / "intrinsic_color.txt"), {}};
  files.depths = depths_in(request.scene);
  std::size_t without_pose = 0;
  for (const std::string& name : pictures_in(request.images.value_or(request.scene / "color"))) {
    std::error_code ignored;
    const fs::path pose = pose_file(request.scene, name);
    if (fs::exists(pose, ignored)) {
      files.poses.emplace_back(name, read_whole_file(pose));
    } else {
      ++without_pose;
    }
  }
  Capture posed = parse_scannet(files, sizes_in(request.scene, request.images));
  note_skipped(posed, without_pose, "have no file in pose/");
  return posed;
}

}  // namespace lumatlas
