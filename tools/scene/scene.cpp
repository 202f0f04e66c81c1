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
#include "tools/scene/capture_forms.h"
#include "tools/scene/colmap.h"
#include "tools/scene/posed_photographs.h"
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

// How the file's pixels become the lens's image. Throws InputError unless the file is there and of the lens's size;
// `namer` names the photograph, and `camera` says its size.
Orientation orientation_of(const SceneView& view, const std::string& namer, const std::string& camera) {
  std::error_code error;
  const bool is_there = fs::exists(view.image, error);
  if (error) throw InputError(view.image.string() + ": cannot be looked at (" + error.message() + ")");
  if (!is_there) throw InputError(view.image.string() + ": no such photograph, but " + namer + " names it");
  for (const Orientation orientation : {Orientation::as_stored, Orientation::exif}) {
    if (has_lens_size(view, orientation)) return orientation;
  }
  const ImageSize size = photograph_size(view.image, Orientation::as_stored);
  throw InputError(view.image.string() + ": is " + size_text(size.width, size.height) + " pixels, but " + camera +
                   " is " + size_text(view.lens.width, view.lens.height) +
                   ": put the photographs that the model was made from there");
}

// What the task throws is the caller's, or, where bad views are to be skipped, what is bad about this one.
template <typename Task>
void look_at_photograph(bool skip_bad, SceneView& view, const Task& task) {
  if (!view.bad.empty()) return;
  try {
    task();
  } catch (const InputError& error) {
    if (!skip_bad) throw;
    view.bad = error.what();
  }
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

// The views whose masks are in the folder get them. A folder that was asked for must have one.
void find_masks(const fs::path& folder, bool asked_for, std::vector<SceneView>& views) {
  std::error_code ignored;
  bool found = false;
  if (fs::is_directory(folder, ignored)) {
    for (SceneView& view : views) {
      const fs::path whole_name = folder / (view.name + ".png");
      for (const fs::path& mask : {whole_name, (folder / view.name).replace_extension(".png")}) {
        if (view.mask || !fs::is_regular_file(mask, ignored)) continue;
        view.mask = mask;
        found = true;
      }
    }
  }
  if (found || !asked_for) return;
  throw InputError(folder.string() + ": has a mask of none of the " + std::to_string(views.size()) +
                   " photographs; that of " + views.front().name + " would be " + views.front().name + ".png");
}

void check_has_lens_size(std::uint32_t width, std::uint32_t height, const fs::path& file, const SceneView& view) {
  if (width == view.lens.width && height == view.lens.height) return;
  throw InputError(file.string() + ": is " + size_text(width, height) + " pixels, but its camera is " +
                   size_text(view.lens.width, view.lens.height));
}

// Of each pixel of the photograph whether it may be used; empty: all may.
using UsedPixels = std::vector<bool>;

UsedPixels pixels_with_alpha(const SceneView& view) {
  constexpr std::uint8_t kHalf = 128;
  const std::vector<std::uint8_t> alpha = read_alpha(view.image, view.orientation);
  UsedPixels used(alpha.size());
  std::transform(alpha.begin(), alpha.end(), used.begin(), [](std::uint8_t a) { return a >= kHalf; });
  return used;
}

// A mask is as the photograph is stored: of those that have to be turned for their camera it has the camera's size.
UsedPixels pixels_of_mask(const SceneView& view) {
  Photograph mask = read_photograph(*view.mask, Orientation::as_stored);
  check_has_lens_size(mask.width, mask.height, *view.mask, view);
  UsedPixels used(std::size_t{mask.width} * mask.height);
  for (std::size_t i = 0; i < used.size(); ++i) {
    used[i] = mask.rgb[3 * i] != 0 || mask.rgb[3 * i + 1] != 0 || mask.rgb[3 * i + 2] != 0;
  }
  return used;
}

void take_out(const UsedPixels& used, Photograph& photograph) {
  if (std::find(used.begin(), used.end(), false) == used.end()) return;
  if (photograph.valid.empty()) photograph.valid.assign(used.size(), 255);
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) photograph.valid[i] = 0;
  }
}

SceneViews colmap_views(const fs::path& scene, const glm::dvec3& offset, const PictureFolders& folders) {
  const ColmapModel model = read_colmap_model(scene);
  const std::map<std::uint32_t, Camera> cameras = pinhole_views(model);
  const fs::path folder = folders.images.value_or(scene / "images");
  check_is_folder(folder);
  SceneViews result{scene, {}};
  for (const ColmapImage& image : model.images) {
    SceneView view{image.name, folder / image.name, model.camera_of(image).lens, Orientation::as_stored,
                   cameras.at(image.camera_id)};
    place(view.camera, image, offset);
    result.views.push_back(std::move(view));
  }
  for_each_index(result.views.size(), [&](std::size_t i) {
    const ColmapImage& image = model.images[i];
    SceneView& view = result.views[i];
    look_at_photograph(folders.skip_bad, view, [&] {
      view.orientation =
          orientation_of(view, "image " + std::to_string(image.id) + " of " + model.images_path.string(),
                         "camera " + std::to_string(image.camera_id) + " of " + model.cameras_path.string());
    });
  });
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

void add_depths(const std::vector<PosedDepth>& depths, const fs::path& path, const glm::dvec3& offset,
                SceneViews& scene) {
  const std::vector<Camera> cameras =
      pinhole_views(depths, path, [](const PosedDepth& depth) { return depth.file.string(); });
  for (std::size_t i = 0; i < depths.size(); ++i) {
    SceneDepth depth{scene.root / depths[i].file, depths[i].unit, depths[i].lens, cameras[i]};
    place(depth.camera, depths[i], offset);
    scene.depths.push_back(std::move(depth));
  }
}

SceneViews posed_views(const fs::path& scene, const CaptureForm& form, const glm::dvec3& offset,
                       const PictureFolders& folders) {
  const fs::path& path = form.file;
  if (folders.images) check_is_folder(*folders.images);
  PosedPhotographs posed = form.read(scene, folders.images);
  const std::vector<Camera> cameras = pinhole_views(posed.photographs, path);
  SceneViews result{scene, {}};
  result.notes = std::move(posed.notes);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const PosedPhotograph& frame = posed.photographs[i];
    SceneView view{frame.name, folders.images ? *folders.images / frame.name : scene / frame.file, frame.lens,
                   Orientation::as_stored, cameras[i]};
    if (frame.mask && !folders.masks) view.mask = scene / *frame.mask;
    place(view.camera, frame, offset);
    result.views.push_back(std::move(view));
  }
  add_depths(posed.depths, path, offset, result);
  for_each_index(result.views.size(), [&](std::size_t i) {
    SceneView& view = result.views[i];
    look_at_photograph(folders.skip_bad, view, [&] {
      view.orientation = orientation_of(view, path.string(), "its camera in " + path.string());
    });
  });
  return result;
}

// Decodes every photograph and mask: damage behind a header shows in no other way.
void find_bad(SceneViews& scene) {
  for_each_index(scene.views.size(), [&](std::size_t i) {
    SceneView& view = scene.views[i];
    look_at_photograph(true, view, [&] {
      (void)read_photograph(view.image, view.orientation);
      if (view.mask) (void)pixels_of_mask(view);
    });
  });
  const auto is_bad = [](const SceneView& view) { return !view.bad.empty(); };
  if (!std::all_of(scene.views.begin(), scene.views.end(), is_bad)) return;
  throw InputError(scene.root.string() + ": none of its " + std::to_string(scene.views.size()) +
                   " photographs can be used; the first: " + scene.views.front().bad);
}

}  // namespace

SceneViews read_scene_views(const fs::path& scene, const glm::dvec3& offset, const PictureFolders& folders) {
  const std::vector<CaptureForm> forms = forms_in(scene);
  const bool is_posed = !forms.empty() && forms.front().read;
  SceneViews result =
      is_posed ? posed_views(scene, forms.front(), offset, folders) : colmap_views(scene, offset, folders);
  result.form = is_posed ? forms.front().name : "COLMAP";
  if (const std::string note = other_forms_note(forms); !note.empty()) result.notes.push_back(note);
  find_masks(folders.masks.value_or(scene / "masks"), folders.masks.has_value(), result.views);
  if (folders.skip_bad) find_bad(result);
  return result;
}

void leave_out_bad(const SceneViews& scene, std::vector<std::size_t>& ranks) {
  std::erase_if(ranks, [&](std::size_t rank) { return !scene.views[rank].bad.empty(); });
}

std::size_t masked_views(const SceneViews& scene) {
  return static_cast<std::size_t>(std::count_if(scene.views.begin(), scene.views.end(),
                                                [](const SceneView& view) { return view.mask.has_value(); }));
}

Photograph load_photograph(const SceneView& view) {
  Photograph photograph = read_photograph(view.image, view.orientation);
  check_has_lens_size(photograph.width, photograph.height, view.image, view);
  take_out(pixels_with_alpha(view), photograph);
  if (view.mask) take_out(pixels_of_mask(view), photograph);
  return undistort(std::move(photograph), view.lens, view.camera, view.correction);
}

}  // namespace lumatlas
