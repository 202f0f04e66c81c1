// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/scene_list.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <numeric>
#include <stdexcept>
#include <system_error>
#include <tuple>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "tools/scene/for_each_index.h"
#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/capture_forms.h"
#include "tools/scene/geo_reference.h"
#include "tools/scene/lenses/undistortion.h"
#include "tools/scene/picture_shape.h"
#include "tools/scene/scene_notes.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

// x_cam = R x + t = R (x - offset) + (t + R offset). Takes a ColmapImage, a PosedPhotograph or a PosedDepth.
template <typename Posed>
void place(Camera& camera, const Posed& posed, const glm::dvec3& offset) {
  camera.cam_from_world_rotation = glm::mat3_cast(posed.cam_from_world_rotation);
  camera.cam_from_world_translation = posed.cam_from_world_translation + camera.cam_from_world_rotation * offset;
}

void check_is_folder(const fs::path& folder) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::none) {
    throw InputError(folder.string() + ": cannot be accessed (" + error.message() + ")");
  }
  if (!fs::is_directory(status)) {
    throw InputError(folder.string() + ": no such folder, but the photographs must be in it");
  }
}

// The pinhole cameras, of identity pose, of lenses; equal ones are worked out once. What is wrong with one is its
// complaint.
struct PinholeView {
  Camera camera;
  std::string complaint;
};
std::vector<PinholeView> pinhole_views(const std::vector<CameraModel>& lenses) {
  std::vector<std::size_t> order(lenses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto key = [&](std::size_t i) {
    return std::tie(lenses[i].model, lenses[i].width, lenses[i].height, lenses[i].parameters);
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  std::vector<std::size_t> firsts;  // in `order`, of equal lenses
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || lenses[order[i]] != lenses[order[i - 1]]) firsts.push_back(i);
  }
  std::vector<PinholeView> views(lenses.size());
  for_each_index(firsts.size(), [&](std::size_t group) {
    PinholeView view;
    try {
      view.camera = pinhole_view(lenses[order[firsts[group]]]);
    } catch (const std::invalid_argument& error) {
      view.complaint = error.what();
    }
    const std::size_t end = group + 1 < firsts.size() ? firsts[group + 1] : order.size();
    for (std::size_t i = firsts[group]; i < end; ++i) views[order[i]] = view;
  });
  return views;
}

std::vector<SceneDepth> placed_depths(const Capture& capture, const fs::path& scene, const glm::dvec3& offset) {
  std::vector<CameraModel> lenses;
  for (const PosedDepth& depth : capture.depths) lenses.push_back(depth.lens);
  const std::vector<PinholeView> views = pinhole_views(lenses);
  std::vector<SceneDepth> result;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const PosedDepth& posed = capture.depths[i];
    if (!views[i].complaint.empty()) {
      throw InputError(capture.file.string() + ": the camera of " + posed.file.string() + ": " + views[i].complaint);
    }
    SceneDepth depth{scene / posed.file, posed.unit, posed.lens, views[i].camera};
    if (posed.confidence) depth.confidence = scene / *posed.confidence;
    place(depth.camera, posed, offset);
    result.push_back(std::move(depth));
  }
  return result;
}

// One that stands for the lens of a photograph that cannot be used.
CameraModel any_lens() {
  return {LensModel::kPinhole, 1, 1, {1, 1, 0.5, 0.5}};
}

std::string folder_name(const PosedPhotograph& photograph) {
  return photograph.panorama ? fs::path(photograph.name).parent_path().generic_string() : photograph.name;
}

ListedView listed_view(const PosedPhotograph& photograph, const PinholeView& pinhole, const Capture& capture,
                       const fs::path& scene, const PictureFolders& folders) {
  const bool given = photograph.named_by.empty();
  ListedView listed{
      {photograph.name, folders.images ? *folders.images / folder_name(photograph) : scene / photograph.file,
       photograph.bad.empty() ? photograph.lens : any_lens(), Orientation::as_stored, pinhole.camera},
      given ? capture.file.string() : photograph.named_by,
      given ? "its camera in " + capture.file.string() : photograph.sized_by};
  SceneView& view = listed.view;
  if (photograph.mask && !folders.masks) view.mask = scene / *photograph.mask;
  view.bad = photograph.bad;
  view.black_rim = photograph.black_rim;
  view.panorama = photograph.panorama;
  view.held_out = photograph.held_out;
  if (pinhole.complaint.empty()) return listed;
  const std::string complaint =
      given ? capture.file.string() + ": the camera of " + photograph.name : photograph.sized_by;
  if (!folders.skip_bad) throw InputError(complaint + ": " + pinhole.complaint);
  view.bad = complaint + ": " + pinhole.complaint;
  view.lens = any_lens();
  view.camera = pinhole_view(view.lens);
  return listed;
}

void scale_lens(ListedView& listed, const ImageSize& size) {
  SceneView& view = listed.view;
  listed.scale = static_cast<double>(size.width) / size_of_file(view).width;
  if (view.panorama) {
    view.panorama->size = size;
    return;
  }
  view.lens = scaled(view.lens, size.width, size.height);
  const Camera pose = view.camera;
  view.camera = pinhole_view(view.lens);
  view.camera.cam_from_world_rotation = pose.cam_from_world_rotation;
  view.camera.cam_from_world_translation = pose.cam_from_world_translation;
}

// Takes the georeference from the file beside the scene where the form has none.
void note_reference_beside(const fs::path& scene, Capture& capture) {
  if (capture.georeference) return;
  capture.georeference = reference_beside(scene);
  if (!capture.georeference) return;
  capture.notes.push_back("by " + reference_file_beside(scene)->string() + ", its coordinates are " +
                          text_of(*capture.georeference));
}

}  // namespace

SceneList list_scene_views(const fs::path& scene, const glm::dvec3& offset, const PictureFolders& folders) {
  if (folders.images) check_is_folder(*folders.images);
  Capture capture =
      read_capture({scene, folders.images, folders.skip_bad ? BadPhotographs::keep : BadPhotographs::refuse});
  std::vector<CameraModel> lenses;
  for (const PosedPhotograph& photograph : capture.photographs) {
    lenses.push_back(photograph.bad.empty() ? photograph.lens : any_lens());
  }
  const std::vector<PinholeView> pinholes = pinhole_views(lenses);
  note_reference_beside(scene, capture);
  SceneList result{capture.form,     std::move(capture.notes),       {}, placed_depths(capture, scene, offset),
                   capture.left_out, std::move(capture.georeference)};
  for (std::size_t i = 0; i < pinholes.size(); ++i) {
    const PosedPhotograph& photograph = capture.photographs[i];
    result.views.push_back(listed_view(photograph, pinholes[i], capture, scene, folders));
    place(result.views.back().view.camera, photograph, offset);
  }
  return result;
}

std::vector<fs::path> files_of_list(const fs::path& scene) {
  const std::vector<CaptureForm> forms = forms_in(scene);
  if (forms.empty()) return {};
  std::vector<fs::path> files{forms.front().file};
  if (const std::optional<fs::path> reference = reference_file_beside(scene)) files.push_back(*reference);
  if (forms.front().name != "COLMAP") return files;
  for (const char* const name : {"cameras.bin", "cameras.txt", "images.bin", "images.txt"}) {
    std::error_code ignored;
    fs::path file = files.front().parent_path() / name;
    if (file != files.front() && fs::exists(file, ignored)) files.push_back(std::move(file));
  }
  return files;
}

void fit_to_photograph(ListedView& listed) {
  SceneView& view = listed.view;
  std::error_code error;
  const bool is_there = fs::exists(view.image, error);
  if (error) throw InputError(view.image.string() + ": cannot be accessed (" + error.message() + ")");
  if (!is_there) {
    const bool has_folder = fs::is_directory(view.image.parent_path(), error);
    throw InputError(view.image.string() + ": no such photograph, but " + listed.named_by + " names it" +
                     (has_folder ? "" : ": name the folder of the photographs with --images"));
  }
  const ImageSize expected = size_of_file(view);
  constexpr std::array kOrientations{Orientation::as_stored, Orientation::exif};
  for (const Orientation orientation : kOrientations) {
    view.orientation = orientation;
    const ImageSize size = photograph_size(view.image, orientation);
    if (size.width == expected.width && size.height == expected.height) return;
  }
  for (const Orientation orientation : kOrientations) {
    view.orientation = orientation;
    const ImageSize size = photograph_size(view.image, orientation);
    if (same_shape(size, expected)) return scale_lens(listed, size);
  }
  const ImageSize size = photograph_size(view.image, Orientation::as_stored);
  const ImageSize quarter{size.height, size.width};
  const bool turned =
      same_shape(quarter, expected) || (quarter.width == expected.width && quarter.height == expected.height);
  throw InputError(view.image.string() + ": is " + size_text(size.width, size.height) + " pixels, but " +
                   listed.sized_by + " is " + size_text(expected.width, expected.height) +
                   (turned ? ": it was turned by a quarter after its pose was found; turn it back"
                           : ": put the photographs that the model was made from there"));
}

std::string scaled_lenses_note(const std::vector<ListedView>& views) {
  const auto is_scaled = [](const ListedView& listed) { return listed.scale != 1; };
  const auto count = std::count_if(views.begin(), views.end(), is_scaled);
  if (count == 0) return {};
  const ListedView& first = *std::find_if(views.begin(), views.end(), is_scaled);
  const ImageSize size = size_of_file(first.view);
  constexpr std::ptrdiff_t kMostNamed = 5;
  std::string names;
  for (const ListedView& listed : views) {
    if (is_scaled(listed) && count <= kMostNamed) names += (names.empty() ? ": " : ", ") + listed.view.name;
  }
  return std::to_string(count) + " of " + std::to_string(views.size()) +
         " photographs have another size than the model says, so their lenses are scaled, the first by " +
         number_text(std::round(1000 * first.scale) / 1000) + " to " + size_text(size.width, size.height) + " pixels" +
         names;
}

fs::path mask_folder(const fs::path& scene, const PictureFolders& folders) {
  return folders.masks.value_or(scene / "masks");
}

std::optional<fs::path> mask_of(const SceneView& view, const fs::path& folder) {
  std::error_code ignored;
  for (const fs::path& name : mask_names(photograph_name(view))) {
    if (fs::is_regular_file(folder / name, ignored)) return folder / name;
  }
  return std::nullopt;
}

}  // namespace lumatlas
