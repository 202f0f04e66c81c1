// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/colmap.h"

#include <algorithm>

#include "mesh/base/errors.h"
#include "mesh/base/whole_file.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code error;
  const bool exists = fs::exists(path, error);
  if (error) throw InputError(path.string() + ": cannot be looked at (" + error.message() + ")");
  return exists;
}

struct Files {
  fs::path cameras, images;
  bool binary;
};

// All the places where a model may be, the preferred one first.
std::vector<Files> candidates(const fs::path& scene) {
  std::vector<Files> result;
  for (const fs::path& folder : {scene / "sparse", scene / "sparse" / "0", scene}) {
    result.push_back({folder / "cameras.bin", folder / "images.bin", true});
    result.push_back({folder / "cameras.txt", folder / "images.txt", false});
  }
  return result;
}

Files find_model(const fs::path& scene) {
  const std::vector<Files> all = candidates(scene);
  for (const Files& files : all) {
    if (is_there(files.cameras) && is_there(files.images)) {
      return files;
    }
  }
  for (const Files& files : all) {
    const bool cameras = is_there(files.cameras);
    if (cameras || is_there(files.images)) {
      throw InputError((cameras ? files.images : files.cameras).string() + ": no such file, but COLMAP's model needs " +
                       "it beside " + (cameras ? files.cameras : files.images).filename().string());
    }
  }
  throw InputError(scene.string() + (is_there(scene)
                                         ? ": holds no COLMAP model (cameras.bin and images.bin, or "
                                           "cameras.txt and images.txt, in sparse/, sparse/0/ or itself) and no "
                                           "transforms.json or other form of capture"
                                         : ": no such folder"));
}

void check_cameras_exist(const ColmapModel& model) {
  for (const ColmapImage& image : model.images) {
    (void)model.camera_of(image);
  }
}

}  // namespace

const ColmapCamera& ColmapModel::camera_of(const ColmapImage& image) const {
  const auto found = std::lower_bound(cameras.begin(), cameras.end(), image.camera_id,
                                      [](const ColmapCamera& camera, std::uint32_t id) { return camera.id < id; });
  if (found == cameras.end() || found->id != image.camera_id) {
    throw InputError(images_path.string() + ": image " + std::to_string(image.id) + " ('" + image.name +
                     "') has camera " + std::to_string(image.camera_id) + ", which is not in " +
                     cameras_path.filename().string());
  }
  return *found;
}

ColmapModel read_colmap_model(const fs::path& scene) {
  const Files files = find_model(scene);
  const std::string cameras = read_whole_file(files.cameras);
  const std::string images = read_whole_file(files.images);
  ColmapModel model{files.cameras, files.images, {}, {}};
  model.cameras = files.binary ? parse_cameras_binary(std::as_bytes(std::span(cameras)), files.cameras)
                               : parse_cameras_text(cameras, files.cameras);
  model.images = files.binary ? parse_images_binary(std::as_bytes(std::span(images)), files.images)
                              : parse_images_text(images, files.images);
  if (model.images.empty()) {
    throw InputError(files.images.string() + ": holds no image, so there is nothing to see the scene from");
  }
  std::sort(model.cameras.begin(), model.cameras.end(),
            [](const ColmapCamera& a, const ColmapCamera& b) { return a.id < b.id; });
  std::sort(model.images.begin(), model.images.end(),
            [](const ColmapImage& a, const ColmapImage& b) { return a.name < b.name; });
  check_cameras_exist(model);
  return model;
}

fs::path points_path(const ColmapModel& model) {
  return model.images_path.parent_path() / ("points3D" + model.images_path.extension().string());
}

std::vector<ColmapPoint> read_colmap_points(const ColmapModel& model) {
  const fs::path path = points_path(model);
  const std::string file = read_whole_file(path);
  std::vector<ColmapPoint> points = path.extension() == ".bin"
                                        ? parse_points_binary(std::as_bytes(std::span(file)), path)
                                        : parse_points_text(file, path);
  if (points.empty()) throw InputError(path.string() + ": holds no point");
  return points;
}

}  // namespace lumatlas
