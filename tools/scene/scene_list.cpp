// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/scene_list.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "tools/scene/for_each_index.h"
#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/capture_forms.h"
#include "tools/scene/forms/colmap.h"
#include "tools/scene/scene_notes.h"
#include "tools/scene/undistortion.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

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

// x_cam = R x + t = R (x - offset) + (t + R offset).
// Of a ColmapImage, a PosedPhotograph or a PosedDepth.
template <typename Posed>
void place(Camera& camera, const Posed& posed, const glm::dvec3& offset) {
  camera.cam_from_world_rotation = glm::mat3_cast(posed.cam_from_world_rotation);
  camera.cam_from_world_translation = posed.cam_from_world_translation + camera.cam_from_world_rotation * offset;
}

void check_is_folder(const fs::path& folder) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::none) {
    throw InputError(folder.string() + ": cannot be looked at (" + error.message() + ")");
  }
  if (!fs::is_directory(status)) {
    throw InputError(folder.string() + ": no such folder, but the photographs must be in it");
  }
}

SceneList colmap_list(const fs::path& scene, const glm::dvec3& offset, const PictureFolders& folders) {
  const ColmapModel model = read_colmap_model(scene);
  const std::map<std::uint32_t, Camera> cameras = pinhole_views(model);
  const fs::path folder = folders.images.value_or(scene / "images");
  check_is_folder(folder);
  SceneList result{"COLMAP", {}, {}, {}};
  if (!model.note.empty()) result.notes.push_back(model.note);
  for (const ColmapImage& image : model.images) {
    SceneView view{image.name, folder / image.name, model.camera_of(image).lens, Orientation::as_stored,
                   cameras.at(image.camera_id)};
    place(view.camera, image, offset);
    result.views.push_back({std::move(view), "image " + std::to_string(image.id) + " of " + model.images_path.string(),
                            "camera " + std::to_string(image.camera_id) + " of " + model.cameras_path.string()});
  }
  return result;
}

// The pinhole cameras, of identity pose, of photographs or depth images. Lenses that these share are worked out once.
template <typename Posed, typename Name>
std::vector<Camera> pinhole_views(const std::vector<Posed>& frames, const fs::path& path, const Name& name) {
  std::vector<Camera> result;
  const CameraModel* last = nullptr;
  for (const Posed& frame : frames) {
    try {
      result.push_back(last && *last == frame.lens ? result.back() : pinhole_view(frame.lens));
    } catch (const std::invalid_argument& error) {
      throw InputError(path.string() + ": the camera of " + name(frame) + ": " + error.what());
    }
    last = &frame.lens;
  }
  return result;
}

std::vector<Camera> pinhole_views(const std::vector<PosedPhotograph>& frames, const fs::path& path) {
  return pinhole_views(frames, path, [](const PosedPhotograph& frame) { return frame.name; });
}

std::vector<SceneDepth> placed_depths(const std::vector<PosedDepth>& depths, const fs::path& scene,
                                      const fs::path& path, const glm::dvec3& offset) {
  const std::vector<Camera> cameras =
      pinhole_views(depths, path, [](const PosedDepth& depth) { return depth.file.string(); });
  std::vector<SceneDepth> result;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    SceneDepth depth{scene / depths[i].file, depths[i].unit, depths[i].lens, cameras[i]};
    if (depths[i].confidence) depth.confidence = scene / *depths[i].confidence;
    place(depth.camera, depths[i], offset);
    result.push_back(std::move(depth));
  }
  return result;
}

SceneList posed_list(const fs::path& scene, const CaptureForm& form, const glm::dvec3& offset,
                     const PictureFolders& folders) {
  const fs::path& path = form.file;
  if (folders.images) check_is_folder(*folders.images);
  Capture posed = form.read(scene, folders.images);
  const std::vector<Camera> cameras = pinhole_views(posed.photographs, path);
  SceneList result{
      form.name, std::move(posed.notes), {}, placed_depths(posed.depths, scene, path, offset), posed.left_out};
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const PosedPhotograph& frame = posed.photographs[i];
    SceneView view{frame.name, folders.images ? *folders.images / frame.name : scene / frame.file, frame.lens,
                   Orientation::as_stored, cameras[i]};
    if (frame.mask && !folders.masks) view.mask = scene / *frame.mask;
    view.black_rim = frame.black_rim;
    place(view.camera, frame, offset);
    result.views.push_back({std::move(view), path.string(), "its camera in " + path.string()});
  }
  return result;
}

bool has_lens_size(const SceneView& view, Orientation orientation) {
  const ImageSize size = photograph_size(view.image, orientation);
  return size.width == view.lens.width && size.height == view.lens.height;
}

}  // namespace

SceneList list_scene_views(const fs::path& scene, const glm::dvec3& offset, const PictureFolders& folders) {
  const std::vector<CaptureForm> forms = forms_in(scene);
  SceneList result = !forms.empty() && forms.front().read ? posed_list(scene, forms.front(), offset, folders)
                                                          : colmap_list(scene, offset, folders);
  if (std::string note = other_forms_note(forms); !note.empty()) result.notes.push_back(std::move(note));
  return result;
}

std::vector<fs::path> files_of_list(const fs::path& scene) {
  const std::vector<CaptureForm> forms = forms_in(scene);
  if (forms.empty()) return {};
  std::vector<fs::path> files{forms.front().file};
  if (forms.front().read) return files;
  for (const char* const name : {"cameras.bin", "cameras.txt", "images.bin", "images.txt"}) {
    std::error_code ignored;
    fs::path file = files.front().parent_path() / name;
    if (file != files.front() && fs::exists(file, ignored)) files.push_back(std::move(file));
  }
  return files;
}

Orientation orientation_of(const ListedView& listed) {
  const SceneView& view = listed.view;
  std::error_code error;
  const bool is_there = fs::exists(view.image, error);
  if (error) throw InputError(view.image.string() + ": cannot be looked at (" + error.message() + ")");
  if (!is_there) throw InputError(view.image.string() + ": no such photograph, but " + listed.named_by + " names it");
  for (const Orientation orientation : {Orientation::as_stored, Orientation::exif}) {
    if (has_lens_size(view, orientation)) return orientation;
  }
  const ImageSize size = photograph_size(view.image, Orientation::as_stored);
  throw InputError(view.image.string() + ": is " + size_text(size.width, size.height) + " pixels, but " +
                   listed.sized_by + " is " + size_text(view.lens.width, view.lens.height) +
                   ": put the photographs that the model was made from there");
}

fs::path mask_folder(const fs::path& scene, const PictureFolders& folders) {
  return folders.masks.value_or(scene / "masks");
}

std::optional<fs::path> mask_of(const SceneView& view, const fs::path& folder) {
  std::error_code ignored;
  for (const fs::path& name : mask_names(view.name)) {
    if (fs::is_regular_file(folder / name, ignored)) return folder / name;
  }
  return std::nullopt;
}

}  // namespace lumatlas
