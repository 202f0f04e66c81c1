// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/scene.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "tools/scene/for_each_index.h"
#include "tools/scene/lenses/black_rim.h"
#include "tools/scene/lenses/undistortion.h"
#include "tools/scene/picture_shape.h"
#include "tools/scene/scene_list.h"
#include "tools/scene/scene_notes.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

// Passes on an exception of the task, or, if bad views are to be skipped, notes it as the view's fault.
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

// The views whose masks are in the folder get them, and what does not fit is noted. A folder that was asked for must
// have one.
void find_masks(const fs::path& folder, bool asked_for, SceneViews& scene) {
  std::error_code ignored;
  bool found = false;
  const bool is_there = fs::is_directory(folder, ignored);
  for (SceneView& view : scene.views) {
    if (view.mask || !is_there) continue;
    view.mask = mask_of(view, folder);
    found = found || view.mask;
  }
  if (asked_for && !found) throw InputError(no_mask_fits(folder, scene.views));
  if (is_there) note_masks(folder, scene);
}

void check_has_size_of_file(std::uint32_t width, std::uint32_t height, const fs::path& file, const SceneView& view) {
  const ImageSize expected = size_of_file(view);
  if (width == expected.width && height == expected.height) return;
  throw InputError(file.string() + ": is " + size_text(width, height) + " pixels, but its camera is " +
                   size_text(expected.width, expected.height));
}

// For each pixel of the photograph, whether it may be used; empty: all may.
using UsedPixels = std::vector<bool>;

UsedPixels pixels_with_alpha(const SceneView& view) {
  constexpr std::uint8_t kHalf = 128;
  const std::vector<std::uint8_t> alpha = read_alpha(view.image, view.orientation);
  UsedPixels used(alpha.size());
  std::transform(alpha.begin(), alpha.end(), used.begin(), [](std::uint8_t a) { return a >= kHalf; });
  return used;
}

// A mask is as the photograph is stored: of those that have to be turned for their camera it has the camera's size. One
// of another size but the same shape is scaled: a pixel is used if the one that its middle falls on is.
UsedPixels pixels_of_mask(const SceneView& view) {
  const Photograph mask = read_photograph(*view.mask, Orientation::as_stored);
  const ImageSize size = size_of_file(view);
  if (!same_shape({mask.width, mask.height}, size)) {
    check_has_size_of_file(mask.width, mask.height, *view.mask, view);
  }
  UsedPixels used(std::size_t{size.width} * size.height);
  for (std::size_t i = 0; i < used.size(); ++i) {
    const std::size_t column = (2 * (i % size.width) + 1) * mask.width / (2 * std::size_t{size.width});
    const std::size_t row = (2 * (i / size.width) + 1) * mask.height / (2 * std::size_t{size.height});
    const std::uint8_t* const rgb = &mask.rgb[3 * (row * mask.width + column)];
    used[i] = rgb[0] != 0 || rgb[1] != 0 || rgb[2] != 0;
  }
  return used;
}

UsedPixels pixels_without_rim(const Photograph& photograph) {
  UsedPixels used = black_rim(photograph);
  used.flip();
  return used;
}

void take_out(const UsedPixels& used, Photograph& photograph) {
  if (std::find(used.begin(), used.end(), false) == used.end()) return;
  if (photograph.valid.empty()) photograph.valid.assign(used.size(), 255);
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) photograph.valid[i] = 0;
  }
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
  SceneList list = list_scene_views(scene, offset, folders);
  SceneViews result{
      scene, {}, std::move(list.depths), std::move(list.form), std::move(list.notes), std::move(list.georeference)};
  for_each_index(list.views.size(), [&](std::size_t i) {
    look_at_photograph(folders.skip_bad, list.views[i].view, [&] { fit_to_photograph(list.views[i]); });
  });
  if (std::string note = scaled_lenses_note(list.views); !note.empty()) result.notes.push_back(std::move(note));
  for (ListedView& listed : list.views) result.views.push_back(std::move(listed.view));
  find_masks(mask_folder(scene, folders), folders.masks.has_value(), result);
  note_unposed(list.left_out, result);
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

std::size_t held_out_views(const SceneViews& scene) {
  return static_cast<std::size_t>(
      std::count_if(scene.views.begin(), scene.views.end(), [](const SceneView& view) { return view.held_out; }));
}

ImageSize size_of_file(const SceneView& view) {
  return view.panorama ? view.panorama->size : ImageSize{view.lens.width, view.lens.height};
}

std::string photograph_name(const SceneView& view) {
  return view.panorama ? fs::path(view.name).parent_path().generic_string() : view.name;
}

Photograph load_photograph(const SceneView& view) {
  Photograph photograph = read_photograph(view.image, view.orientation);
  check_has_size_of_file(photograph.width, photograph.height, view.image, view);
  take_out(pixels_with_alpha(view), photograph);
  if (view.black_rim) take_out(pixels_without_rim(photograph), photograph);
  if (view.mask) take_out(pixels_of_mask(view), photograph);
  if (view.panorama) photograph = view_of_panorama(photograph, *view.panorama, pinhole_view(view.lens));
  return undistort(std::move(photograph), view.lens, view.camera, view.correction, view.motion);
}

}  // namespace lumatlas
