// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/photogrammetry/bundler.h"

#include <array>
#include <glm/glm.hpp>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/scene/forms/fields/brown_lens.h"
#include "tools/scene/forms/fields/text_numbers.h"
#include "tools/scene/forms/fields/text_rows.h"
#include "tools/scene/forms/photographs/measured_size.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBundleStart = "# Bundle file";
constexpr std::string_view kBundleVersion = "# Bundle file v0.3";

struct BundlerCamera {
  double f = 0, k1 = 0, k2 = 0;
  glm::dmat3 R{1.0};  // cam from world
  glm::dvec3 t{0.0};
};

BundlerCamera take_bundler_camera(TextNumbers& numbers, std::size_t index) {
  const std::string of = " of camera " + std::to_string(index);
  BundlerCamera camera;
  camera.f = numbers.number("the focal length" + of);
  camera.k1 = numbers.number("k1" + of);
  camera.k2 = numbers.number("k2" + of);
  for (int i = 0; i < 9; ++i) camera.R[i % 3][i / 3] = numbers.number("the rotation" + of);
  for (int axis = 0; axis < 3; ++axis) camera.t[axis] = numbers.number("the translation" + of);
  return camera;
}

// Position, colour, then the views that show the point: camera, number of the feature, and where it is.
void take_bundler_points(TextNumbers& numbers, std::uint64_t count, std::vector<MeasuredExtent>& extents) {
  constexpr std::uint64_t kLeastViewBytes = 8;  // four digits with blanks between them
  for (std::uint64_t point = 0; point < count; ++point) {
    const std::string of = " of point " + std::to_string(point);
    for (int i = 0; i < 6; ++i) (void)numbers.number_or_nan("the position" + of);
    for (std::uint64_t left = numbers.count("the number of views" + of, kLeastViewBytes); left > 0; --left) {
      const double camera = numbers.number("a view" + of);
      (void)numbers.number_or_nan("a view" + of);
      const double x = numbers.number_or_nan("a view" + of);
      const double y = numbers.number_or_nan("a view" + of);
      if (!(camera >= 0 && camera < static_cast<double>(extents.size()))) {
        numbers.refuse("a view" + of + " is of a camera that is not there");
      }
      extents[static_cast<std::size_t>(camera)].add(x, y);
    }
  }
}

// The file's name: what is left of its line without "0 FOCAL_LENGTH" at the end.
std::string_view listed_name(const TextRow& row) {
  std::size_t fields = row.fields.size();
  if (fields >= 3 && parse_number(row.fields[fields - 1]) && parse_number(row.fields[fields - 2])) fields -= 2;
  const char* const first = row.fields.front().data();
  const char* const end = row.fields[fields - 1].data() + row.fields[fields - 1].size();
  return {first, static_cast<std::size_t>(end - first)};
}

std::string camera_named(const fs::path& path, std::size_t index, const PosedPhotograph& photograph) {
  return path.string() + ": camera " + std::to_string(index) + " (" + in_quotes(photograph.name) + "): ";
}

void refuse_or_keep(PosedPhotograph& photograph, BadPhotographs bad, const std::string& sentence) {
  if (bad == BadPhotographs::refuse) throw InputError(sentence);
  if (photograph.bad.empty()) photograph.bad = sentence;
}

CameraModel bundler_lens(const BundlerCamera& camera, const ImageSize& size, std::uint32_t scale) {
  BrownLens lens{size.width * scale, size.height * scale};
  lens.fx = lens.fy = camera.f;
  lens.cx = 0.5 * lens.width;
  lens.cy = 0.5 * lens.height;
  lens.k1 = camera.k1;
  lens.k2 = camera.k2;
  return lens_of(lens);
}

}  // namespace

Capture parse_bundler(std::string_view text, const fs::path& path, std::string_view list, const fs::path& list_path,
                      const PhotographLookup& photographs) {
  constexpr std::uint64_t kLeastCameraBytes = 30, kLeastPointBytes = 14;  // numbers of one digit
  TextNumbers numbers(text, path);
  const std::string_view version = numbers.line();
  if (version != kBundleVersion) {
    throw InputError(path.string() + ": begins with " + in_quotes(version) + ", must begin with " +
                     in_quotes(kBundleVersion));
  }
  const std::uint64_t count = numbers.count("the number of cameras", kLeastCameraBytes);
  const std::uint64_t points = numbers.count("the number of points", kLeastPointBytes);
  const std::vector<TextRow> rows = rows_of(list);
  if (rows.size() != count) {
    throw InputError(path.string() + ": has " + std::to_string(count) + " cameras, but " + list_path.string() +
                     " names " + std::to_string(rows.size()) + " photographs");
  }
  Capture posed;
  std::vector<BundlerCamera> cameras;
  std::vector<ImageSize> sizes;
  std::vector<std::size_t> placed;  // the numbers of the cameras, as points count them
  for (std::size_t index = 0; index < count; ++index) {
    const BundlerCamera camera = take_bundler_camera(numbers, index);
    if (camera.f == 0) continue;
    PosedPhotograph photograph = photographs.find(listed_name(rows[index]));
    const glm::dmat3 world_from_camera = glm::transpose(camera.R);
    const std::string broken =
        set_pose(photograph, world_from_camera, -(world_from_camera * camera.t), CameraAxes::right_up_backward);
    if (!broken.empty()) {
      refuse_or_keep(photograph, photographs.bad, camera_named(path, index, photograph) + "its pose " + broken);
    }
    sizes.push_back(photographs.size_of(photograph));
    cameras.push_back(camera);
    placed.push_back(index);
    posed.photographs.push_back(std::move(photograph));
  }
  std::vector<MeasuredExtent> all_extents(count), extents;
  take_bundler_points(numbers, points, all_extents);
  for (const std::size_t index : placed) extents.push_back(all_extents[index]);
  const std::uint32_t scale = measured_scale(extents, sizes, path);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    try {
      posed.photographs[i].lens = bundler_lens(cameras[i], sizes[i], scale);
    } catch (const std::invalid_argument& error) {
      PosedPhotograph& photograph = posed.photographs[i];
      refuse_or_keep(photograph, photographs.bad,
                     camera_named(path, placed[i], photograph) + "an impossible camera: " + error.what());
    }
  }
  note_skipped(posed, count - cameras.size(), "were not placed (their focal length is 0)");
  finish(posed, path, photographs.bad);
  posed.notes.push_back(measured_scale_note(scale, path) + ", and their middles are taken to be the principal points");
  return posed;
}

std::optional<fs::path> find_bundler(const fs::path& scene) {
  std::error_code ignored;
  for (const char* const name : {"bundle.out", "bundle.rd.out", "bundle/bundle.out"}) {
    const fs::path file = scene / name;
    if (fs::is_regular_file(file, ignored) && first_bytes(file).starts_with(kBundleStart)) return file;
  }
  return std::nullopt;
}

namespace {

fs::path list_beside(const fs::path& bundle, const fs::path& scene) {
  std::vector<fs::path> places{bundle.parent_path() / "list.txt", scene / "list.txt"};
  if (bundle.filename() == "bundle.rd.out") places.insert(places.begin(), bundle.parent_path() / "list.rd.txt");
  std::error_code ignored;
  for (const fs::path& place : places) {
    if (fs::is_regular_file(place, ignored)) return place;
  }
  throw InputError(bundle.string() +
                   ": has no list.txt beside it, which names the photographs in the order of the cameras: copy it from "
                   "where Bundler was run");
}

}  // namespace

Capture read_bundler(const CaptureRequest& request) {
  const fs::path path = find_bundler(request.scene).value();
  const fs::path list = list_beside(path, request.scene);
  PhotographLookup lookup = photographs_of(request);
  lookup.find = [find = lookup.find](std::string_view name) { return find(name_without(fs::path(name), "images")); };
  return parse_bundler(read_whole_file(path), path, read_whole_file(list), list, lookup);
}

}  // namespace lumatlas
