// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/scene.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/scene/colmap.h"
#include "tools/scene/undistortion.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

// Runs task(0) ... task(count - 1) in parallel; of the InputErrors, the one of the least index is thrown.
template <typename Task>
void for_each_index(std::size_t count, const Task& task) {
  std::vector<std::string> errors(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    try {
      task(i);
    } catch (const InputError& error) {
      errors[i] = error.what();
    }
  });
  const auto first = std::find_if(errors.begin(), errors.end(), [](const std::string& e) { return !e.empty(); });
  if (first != errors.end()) {
    throw InputError(*first);
  }
}

// The pinhole cameras, of identity pose, of the cameras that some image has; by camera id.
std::map<std::uint32_t, Camera> pinhole_views(const ColmapModel& model) {
  std::vector<ColmapCamera> used;
  for (const ColmapImage& image : model.images) {
    used.push_back(model.camera_of(image));
  }
  const auto by_id = [](const ColmapCamera& a, const ColmapCamera& b) { return a.id < b.id; };
  const auto same_id = [](const ColmapCamera& a, const ColmapCamera& b) { return a.id == b.id; };
  std::sort(used.begin(), used.end(), by_id);
  used.erase(std::unique(used.begin(), used.end(), same_id), used.end());
  std::vector<Camera> cameras(used.size());
  for_each_index(used.size(), [&](std::size_t i) {
    try {
      cameras[i] = pinhole_view(used[i].lens);
    } catch (const std::invalid_argument& error) {
      throw InputError(model.cameras_path.string() + ": camera " + std::to_string(used[i].id) + ": " + error.what());
    }
  });
  std::map<std::uint32_t, Camera> result;
  for (std::size_t i = 0; i < used.size(); ++i) {
    result.emplace(used[i].id, cameras[i]);
  }
  return result;
}

std::string size_text(std::uint32_t width, std::uint32_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

bool has_lens_size(const SceneView& view, Orientation orientation) {
  const ImageSize size = photograph_size(view.image, orientation);
  return size.width == view.lens.width && size.height == view.lens.height;
}

// How the file's pixels become the lens's image. Throws InputError unless the file is there and of the lens's size.
Orientation orientation_of(const SceneView& view, const ColmapImage& image, const ColmapModel& model) {
  std::error_code error;
  const bool is_there = fs::exists(view.image, error);
  if (error) throw InputError(view.image.string() + ": cannot be looked at (" + error.message() + ")");
  if (!is_there) {
    throw InputError(view.image.string() + ": no such photograph, but image " + std::to_string(image.id) + " of " +
                     model.images_path.string() + " names it");
  }
  for (const Orientation orientation : {Orientation::as_stored, Orientation::exif}) {
    if (has_lens_size(view, orientation)) return orientation;
  }
  const ImageSize size = photograph_size(view.image, Orientation::as_stored);
  throw InputError(view.image.string() + ": is " + size_text(size.width, size.height) + " pixels, but camera " +
                   std::to_string(image.camera_id) + " of " + model.cameras_path.string() + " is " +
                   size_text(view.lens.width, view.lens.height) +
                   ": put the photographs that the model was made from there");
}

// x_cam = R x + t = R (x - offset) + (t + R offset).
void place(Camera& camera, const ColmapImage& image, const glm::dvec3& offset) {
  camera.cam_from_world_rotation = glm::mat3_cast(image.cam_from_world_rotation);
  camera.cam_from_world_translation = image.cam_from_world_translation + camera.cam_from_world_rotation * offset;
}

}  // namespace

SceneViews read_scene_views(const fs::path& scene, const glm::dvec3& offset) {
  const ColmapModel model = read_colmap_model(scene);
  const std::map<std::uint32_t, Camera> cameras = pinhole_views(model);
  const fs::path folder = scene / "images";
  std::error_code error;
  const bool is_folder = fs::is_directory(folder, error);
  if (fs::status(folder, error).type() == fs::file_type::none) {
    throw InputError(folder.string() + ": cannot be looked at (" + error.message() + ")");
  }
  if (!is_folder) {
    throw InputError(folder.string() + ": no such folder, but the photographs must be in it");
  }
  SceneViews result{scene, {}};
  for (const ColmapImage& image : model.images) {
    SceneView view{image.name, folder / image.name, model.camera_of(image).lens, Orientation::as_stored,
                   cameras.at(image.camera_id)};
    place(view.camera, image, offset);
    result.views.push_back(std::move(view));
  }
  for_each_index(result.views.size(), [&](std::size_t i) {
    result.views[i].orientation = orientation_of(result.views[i], model.images[i], model);
  });
  return result;
}

Photograph load_photograph(const SceneView& view) {
  Photograph photograph = read_photograph(view.image, view.orientation);
  if (photograph.width != view.lens.width || photograph.height != view.lens.height) {
    throw InputError(view.image.string() + ": is " + size_text(photograph.width, photograph.height) +
                     " pixels, but its camera is " + size_text(view.lens.width, view.lens.height));
  }
  return undistort(std::move(photograph), view.lens, view.camera, view.correction);
}

}  // namespace lumatlas
