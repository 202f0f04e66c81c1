// SPDX-License-Identifier: GPL-3.0-or-later
// https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
#include "tools/scene/forms/tum_rgbd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/scene/forms/fields/brown_lens.h"
#include "tools/scene/forms/fields/text_rows.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr double kNearEnough = 0.02;  // seconds: TUM's own tools use the same

struct TimedPose {
  double time;
  std::size_t line;
  glm::dvec3 center;
  glm::dmat3 world_from_camera;
};

std::vector<TimedPose> poses_of(const std::string& text, const fs::path& path) {
  std::vector<TimedPose> poses;
  for (const TextRow& row : rows_of(text)) {
    std::array<double, 8> v;
    if (row.fields.size() > v.size()) {
      refuse_row(path, row,
                 "has " + std::to_string(row.fields.size()) + " values, must have 8: timestamp tx ty tz qx qy qz qw");
    }
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = number_in(row, i, path);
    const glm::dquat rotation(v[7], v[4], v[5], v[6]);
    const double length = glm::length(rotation);
    if (!(std::abs(length - 1) < 0.01)) refuse_row(path, row, "has a quaternion that is not of length 1");
    poses.push_back({v[0], row.line, {v[1], v[2], v[3]}, glm::mat3_cast(rotation / length)});
  }
  std::stable_sort(poses.begin(), poses.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return poses;
}

const TimedPose* nearest(const std::vector<TimedPose>& poses, double time) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), time, [](const TimedPose& pose, double t) { return pose.time < t; });
  const TimedPose* best = nullptr;
  for (const auto candidate : {after, after == poses.begin() ? after : after - 1}) {
    if (candidate == poses.end()) continue;
    const double distance = std::abs(candidate->time - time);
    if (distance <= kNearEnough && (!best || distance < std::abs(best->time - time))) best = &*candidate;
  }
  return best;
}

// From the middle of the first pixel to its corner, where lumatlas counts from.
constexpr double kHalfPixel = 0.5;

BrownLens lens_of_numbers(const std::vector<double>& v) {
  BrownLens lens{0, 0, v[0], v[1], v[2] + kHalfPixel, v[3] + kHalfPixel};
  if (v.size() >= 8) {
    lens.k1 = v[4];
    lens.k2 = v[5];
    lens.p1 = v[6];
    lens.p2 = v[7];
  }
  if (v.size() == 9) lens.k3 = v[8];
  return lens;
}

BrownLens lens_of_file(const std::string& text, const fs::path& path) {
  const std::vector<TextRow> rows = rows_of(text);
  if (rows.empty()) throw InputError(path.string() + ": holds no numbers, must have fx fy cx cy on one line");
  if (rows.size() > 1) refuse_row(path, rows[1], "is one line too many: all numbers stand on one line");
  const TextRow& row = rows.front();
  const std::size_t count = row.fields.size();
  if (count != 4 && count != 8 && count != 9) {
    refuse_row(
        path, row,
        "has " + std::to_string(count) + " values, must have 4 (fx fy cx cy), 8 (and k1 k2 p1 p2) or 9 (and k3)");
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(number_in(row, i, path));
  return lens_of_numbers(numbers);
}

struct PublishedLens {
  const char* name;
  std::vector<double> numbers;
};

const std::array<PublishedLens, 3>& published_lenses() {
  static const std::array<PublishedLens, 3> lenses{{
      {"freiburg1", {517.3, 516.5, 318.6, 255.3, 0.2624, -0.9531, -0.0054, 0.0026, 1.1633}},
      {"freiburg2", {520.9, 521.0, 325.1, 249.7, 0.2312, -0.7849, -0.0033, -0.0001, 0.9172}},
      {"freiburg3", {535.4, 539.2, 320.1, 247.6}},  // its photographs are undistorted
  }};
  return lenses;
}

BrownLens lens_by_name(const fs::path& folder, const ImageSize& size, Capture& posed) {
  const std::string name = fs::absolute(folder / ".").lexically_normal().parent_path().filename().string();
  for (const PublishedLens& lens : published_lenses()) {
    if (name.find(lens.name) == std::string::npos || size.width != 640 || size.height != 480) continue;
    posed.notes.push_back("the lens is taken to be the one that TUM published for " + std::string(lens.name) +
                          ", which the folder's name tells; a camera.txt would say otherwise");
    return lens_of_numbers(lens.numbers);
  }
  throw InputError((folder / "camera.txt").string() +
                   ": no such file, but only it could tell the lens: write fx fy cx cy on one line, in pixels");
}

CameraModel lens_of_scene(const TumFiles& files, const ImageSize& size, Capture& posed) {
  const fs::path path = files.folder / "camera.txt";
  BrownLens lens = files.camera ? lens_of_file(*files.camera, path) : lens_by_name(files.folder, size, posed);
  lens.width = size.width;
  lens.height = size.height;
  try {
    return lens_of(lens);
  } catch (const std::invalid_argument& error) {
    throw InputError(path.string() + ": an impossible camera: " + error.what());
  }
}

struct PosedFiles {
  std::vector<PosedPhotograph> files;  // sorted by name; without lenses
  std::size_t without_pose = 0;        // others that the list names
};

// Returns the files of a list with timestamps, with the poses nearest in time.
PosedFiles posed_files(const std::string& text, const fs::path& list, const std::vector<TimedPose>& poses,
                       const fs::path& trajectory) {
  PosedFiles result;
  for (const TextRow& row : rows_of(text)) {
    const double time = number_in(row, 0, list);
    if (row.fields.size() != 2) refuse_row(list, row, "must have a timestamp and a file");
    const std::optional<fs::path> file = inner_path(row.fields[1]);
    if (!file) refuse_row(list, row, "names " + in_quotes(row.fields[1]) + ", must be a file in this folder");
    const TimedPose* const pose = nearest(poses, time);
    if (!pose) {
      ++result.without_pose;
      continue;
    }
    PosedPhotograph posed{name_without(*file, "rgb"), *file};
    const std::string broken = set_pose(posed, pose->world_from_camera, pose->center, CameraAxes::right_down_forward);
    if (!broken.empty()) {
      throw InputError(trajectory.string() + ": line " + std::to_string(pose->line) + ": " + broken);
    }
    result.files.push_back(std::move(posed));
  }
  return result;
}

void add_depths(const PosedFiles& found, const CameraModel& lens, Capture& posed) {
  constexpr double kUnit = 1.0 / 5000;  // the unit of TUM depth files
  for (PosedPhotograph depth : found.files) {
    depth.lens = lens;
    posed.depths.push_back(depth_with(depth, depth.file, kUnit));
  }
  note_depths(posed, "taken to have 5000 steps to a unit and the photographs' lens, as TUM registers them" +
                         (found.without_pose == 0
                              ? ""
                              : "; " + std::to_string(found.without_pose) + " more have no pose within 20 ms"));
}

}  // namespace

Capture parse_tum(const TumFiles& files, const std::function<ImageSize(const PosedPhotograph&)>& size_of) {
  const fs::path trajectory = files.folder / "groundtruth.txt";
  const std::vector<TimedPose> poses = poses_of(files.groundtruth, trajectory);
  Capture posed;
  PosedFiles photographs = posed_files(files.rgb, files.folder / "rgb.txt", poses, trajectory);
  posed.photographs = std::move(photographs.files);
  note_skipped(posed, photographs.without_pose, "have no pose within 20 ms in groundtruth.txt");
  finish(posed, trajectory);
  const CameraModel lens = lens_of_scene(files, size_of(posed.photographs.front()), posed);
  for (PosedPhotograph& photograph : posed.photographs) photograph.lens = lens;
  if (files.depth) add_depths(posed_files(*files.depth, files.folder / "depth.txt", poses, trajectory), lens, posed);
  return posed;
}

std::optional<fs::path> find_tum(const fs::path& scene) {
  std::error_code ignored;
  const fs::path trajectory = scene / "groundtruth.txt";
  if (fs::exists(trajectory, ignored) && fs::exists(scene / "rgb.txt", ignored)) return trajectory;
  return std::nullopt;
}

Capture read_tum(const CaptureRequest& request) {
  TumFiles files{request.scene, read_whole_file(request.scene / "rgb.txt"),
                 read_whole_file(request.scene / "groundtruth.txt")};
  std::error_code ignored;
  if (fs::exists(request.scene / "camera.txt", ignored)) files.camera = read_whole_file(request.scene / "camera.txt");
  if (fs::exists(request.scene / "depth.txt", ignored)) files.depth = read_whole_file(request.scene / "depth.txt");
  return parse_tum(files, sizes_in(request.scene, request.images));
}

}  // namespace lumatlas
