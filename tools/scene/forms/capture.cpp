// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/capture.h"

#include <utf8proc.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr double kFarthest = 1e12;   // beyond, double precision cannot tell neighbouring cameras apart
constexpr double kMostError = 0.01;  // rotations are written with few digits by some programs

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_picture(const fs::path& file) {
  constexpr std::array kPhotographEndings{".jpg", ".jpeg", ".png",  ".tif",  ".tiff", ".webp", ".exr",
                                          ".bmp", ".heic", ".heif", ".avif", ".dng",  ".cr2",  ".cr3",
                                          ".nef", ".arw",  ".raf",  ".orf",  ".rw2"};
  return std::find(kPhotographEndings.begin(), kPhotographEndings.end(), lower_case(file.extension().string())) !=
         kPhotographEndings.end();
}

bool ends_a_path(const std::string& name, std::string_view end) {
  if (!name.ends_with(end)) return false;
  return name.size() == end.size() || name[name.size() - end.size() - 1] == '/';
}

std::string without_ending(const std::string& name) {
  return fs::path(name).replace_extension().generic_string();
}

}  // namespace

std::string set_pose(PosedPhotograph& photograph, const glm::dmat3& world_from_camera, const glm::dvec3& center,
                     CameraAxes axes) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(center[axis]) <= kFarthest)) {
      return "puts the camera at " + number_text(center[axis]) + ", which is not within 1e12 of 0";
    }
  }
  const glm::dmat3 square = glm::transpose(world_from_camera) * world_from_camera;
  for (int i = 0; i < 9; ++i) {
    const double expected = i / 3 == i % 3 ? 1 : 0;
    if (!(std::abs(square[i / 3][i % 3] - expected) <= kMostError)) {
      return "does not begin with a rotation: its columns must be of length 1 and at right angles";
    }
  }
  if (glm::determinant(world_from_camera) < 0) return "mirrors the camera, must turn it";
  const double turn = axes == CameraAxes::right_up_backward ? -1 : 1;
  const glm::dmat3 world_from_cam(world_from_camera[0], turn * world_from_camera[1], turn * world_from_camera[2]);
  photograph.cam_from_world_rotation = glm::normalize(glm::quat_cast(glm::transpose(world_from_cam)));
  photograph.cam_from_world_translation = -(photograph.cam_from_world_rotation * center);
  return {};
}

namespace {

LensModel simplest_model(const BrownLens& b) {
  const bool only_brown = b.p3 != 0 || b.p4 != 0 || b.skew != 0;
  if (b.fisheye) return only_brown ? LensModel::kBrownFisheye : LensModel::kThinPrismFisheye;
  if (only_brown || b.k4 != 0) return LensModel::kBrown;
  if (b.k3 != 0) return LensModel::kFullOpenCv;
  const bool distorted = b.k1 != 0 || b.k2 != 0 || b.p1 != 0 || b.p2 != 0;
  return distorted ? LensModel::kOpenCv : LensModel::kPinhole;
}

}  // namespace

CameraModel lens_of(const BrownLens& b) {
  CameraModel lens{simplest_model(b), b.width, b.height, {b.fx, b.fy, b.cx, b.cy}};
  const auto set = [&](std::initializer_list<double> coefficients) {
    std::copy(coefficients.begin(), coefficients.end(), lens.parameters.begin() + 4);
  };
  if (lens.model == LensModel::kBrown || lens.model == LensModel::kBrownFisheye) {
    set({b.skew / b.fx, b.k1, b.k2, b.k3, b.k4, b.p1, b.p2, b.p3, b.p4});
  } else if (lens.model == LensModel::kThinPrismFisheye) {
    set({b.k1, b.k2, b.p1, b.p2, b.k3, b.k4, 0, 0});
  } else if (lens.model == LensModel::kFullOpenCv) {
    set({b.k1, b.k2, b.p1, b.p2, b.k3, 0, 0, 0});
  } else if (lens.model == LensModel::kOpenCv) {
    set({b.k1, b.k2, b.p1, b.p2});
  }
  check(lens);
  return lens;
}

void check_last_row(const std::array<double, 4>& row) {
  constexpr double kMostRounding = 1e-6;
  const auto off = [&](std::size_t i, double expected) { return !(std::abs(row[i] - expected) <= kMostRounding); };
  if (!off(0, 0) && !off(1, 0) && !off(2, 0) && !off(3, 1)) return;
  std::ostringstream text;
  text << "its last row is";
  for (const double value : row) text << ' ' << number_text(value);
  text << ", must be 0 0 0 1" << (off(3, 1) ? "" : ": it is written by columns, must be by rows");
  throw std::invalid_argument(text.str());
}

std::optional<fs::path> inner_path(std::string_view text) {
  const bool has_control =
      std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  const fs::path path = fs::path(text).lexically_normal();
  const bool leaves = std::find(path.begin(), path.end(), fs::path("..")) != path.end();
  if (has_control || path.is_absolute() || leaves || !path.has_filename() || path == ".") return std::nullopt;
  return path;
}

std::string name_without(const fs::path& file, std::string_view first) {
  const std::string name = file.generic_string(), start = std::string(first) + "/";
  return name.starts_with(start) ? name.substr(start.size()) : name;
}

namespace {

bool same_name(const PosedPhotograph& a, const PosedPhotograph& b) {
  return a.name == b.name;
}

// Leaves the first of each name, and names the others in a note.
void leave_out_repeated(Capture& capture, const fs::path& path) {
  std::vector<PosedPhotograph>& all = capture.photographs;
  std::string names;
  const std::size_t count = all.size();
  for (auto second = all.begin(); (second = std::adjacent_find(second, all.end(), same_name)) != all.end();) {
    second = all.erase(second + 1) - 1;
    names += (names.empty() ? "" : ", ") + in_quotes(second->name);
  }
  if (names.empty()) return;
  capture.left_out += count - all.size();
  capture.notes.push_back(path.string() + " names photographs more than once, of which the first is used: " + names);
}

}  // namespace

void finish(Capture& capture, const fs::path& path, BadPhotographs bad) {
  std::vector<PosedPhotograph>& all = capture.photographs;
  if (all.empty()) throw InputError(path.string() + ": gives no photograph a pose, so there is nothing to see");
  std::stable_sort(all.begin(), all.end(),
                   [](const PosedPhotograph& a, const PosedPhotograph& b) { return a.name < b.name; });
  if (bad == BadPhotographs::keep) return leave_out_repeated(capture, path);
  const auto repeated = std::adjacent_find(all.begin(), all.end(), same_name);
  if (repeated == all.end()) return;
  throw InputError(path.string() + ": two frames have the photograph " + in_quotes(repeated->name));
}

void hold_out(Capture& capture, const std::vector<std::string>& paths, const std::string& list) {
  std::vector<std::string> files;
  for (const PosedPhotograph& photograph : capture.photographs) files.push_back(photograph.file.generic_string());
  const PhotographNames names(files);
  std::size_t found = 0;
  for (const std::string& path : paths) {
    const std::string file = names.find_by_path(path);
    for (PosedPhotograph& photograph : capture.photographs) {
      if (photograph.file.generic_string() != file || photograph.held_out) continue;
      photograph.held_out = true;
      ++found;
    }
  }
  capture.notes.push_back(std::to_string(found) + " of " + std::to_string(capture.photographs.size()) +
                          " photographs are for scoring alone, as " + list + " says" +
                          (found == paths.size() ? "" : ", which names " + std::to_string(paths.size())));
}

void note_skipped(Capture& posed, std::size_t skipped, const std::string& why) {
  if (skipped == 0) return;
  posed.left_out += skipped;
  posed.notes.push_back(std::to_string(skipped) + " of " + std::to_string(posed.photographs.size() + skipped) +
                        " photographs " + why + " and are left out");
}

PosedDepth depth_with(const PosedPhotograph& photograph, fs::path file, double unit) {
  return {std::move(file), unit, photograph.lens, photograph.cam_from_world_rotation,
          photograph.cam_from_world_translation};
}

void note_depths(Capture& posed, const std::string& assumed) {
  if (posed.depths.empty()) return;
  posed.notes.push_back(std::to_string(posed.depths.size()) +
                        " depth images, of which `lumatlas mesh` makes a mesh: " + assumed);
}

std::vector<std::string> pictures_in(const fs::path& folder) {
  constexpr std::size_t kMost = 1'000'000;
  std::vector<std::string> names;
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::recursive_directory_iterator() && names.size() < kMost; entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_regular_file(ignored) && is_picture(entry->path())) {
      names.push_back(entry->path().lexically_relative(folder).generic_string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<fs::path> files_ending_in(const fs::path& folder, std::string_view ending) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    const bool fits = lower_case(entry->path().extension().string()) == ending;
    if (fits && entry->is_regular_file(ignored)) files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string first_bytes(const fs::path& file) {
  std::string bytes(4096, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

std::string folded(const std::string& text) {
  constexpr auto kOptions = static_cast<utf8proc_option_t>(UTF8PROC_STABLE | UTF8PROC_COMPOSE | UTF8PROC_CASEFOLD);
  utf8proc_uint8_t* mapped = nullptr;
  const utf8proc_ssize_t length = utf8proc_map(reinterpret_cast<const utf8proc_uint8_t*>(text.data()),
                                               static_cast<utf8proc_ssize_t>(text.size()), &mapped, kOptions);
  const std::unique_ptr<utf8proc_uint8_t, decltype(&std::free)> owner(mapped, &std::free);
  if (length < 0) return lower_case(text);
  return {reinterpret_cast<const char*>(mapped), static_cast<std::size_t>(length)};
}

PhotographNames::PhotographNames(std::vector<std::string> names) : names_(std::move(names)) {
  std::sort(names_.begin(), names_.end());
  for (std::size_t i = 0; i < names_.size(); ++i) {
    folded_.push_back(folded(names_[i]));
    by_file_.emplace(fs::path(folded_[i]).filename().string(), i);
    by_stem_.emplace(fs::path(folded_[i]).stem().string(), i);
  }
}

// Of those that the folded label ends, the only one; or the only one that the label itself ends.
std::optional<std::string> PhotographNames::only_one(const Index& index, const std::string& label, bool with_ending,
                                                     const std::string& named) const {
  const auto form = [&](const std::string& name) { return with_ending ? name : without_ending(name); };
  const std::string folded_label = folded(label);
  std::vector<std::size_t> found, exact;
  const auto [first, last] = index.equal_range(fs::path(folded_label).filename().string());
  for (auto entry = first; entry != last; ++entry) {
    if (!ends_a_path(form(folded_[entry->second]), folded_label)) continue;
    found.push_back(entry->second);
    if (ends_a_path(form(names_[entry->second]), label)) exact.push_back(entry->second);
  }
  if (found.empty()) return std::nullopt;
  if (exact.size() == 1) return names_[exact.front()];
  if (found.size() == 1) return names_[found.front()];
  const std::vector<std::size_t>& several = exact.empty() ? found : exact;
  const auto [a, b] = std::minmax(names_[several[0]], names_[several[1]]);
  throw InputError("the photograph " + in_quotes(named) + " may be " + in_quotes(a) + " or " + in_quotes(b) +
                   ": keep one of them");
}

bool PhotographNames::has(const std::string& name) const {
  return std::binary_search(names_.begin(), names_.end(), name);
}

std::string PhotographNames::find(const std::string& label) const {
  if (has(label)) return label;
  if (const auto name = only_one(by_file_, label, true, label)) return *name;
  if (const auto name = only_one(by_stem_, label, false, label)) return *name;
  return only_one(by_stem_, without_ending(label), false, label).value_or(label);
}

std::string PhotographNames::find_by_path(std::string_view path) const {
  std::string end(path);
  std::replace(end.begin(), end.end(), '\\', '/');
  const std::optional<fs::path> inner = inner_path(end);
  while (true) {
    std::string name = find(end);
    if (has(name)) return name;
    const std::size_t separator = end.find('/');
    if (separator == std::string::npos) return inner ? inner->generic_string() : name;
    end.erase(0, separator + 1);
  }
}

namespace {

std::optional<ImageSize> some_size_in(const fs::path& folder) {
  for (const std::string& name : pictures_in(folder)) {
    try {
      return photograph_size(folder / name, Orientation::as_stored);
    } catch (const InputError&) {  // the next one may be whole
    }
  }
  return std::nullopt;
}

}  // namespace

std::function<ImageSize(const PosedPhotograph&)> sizes_in(const fs::path& scene,
                                                          const std::optional<fs::path>& images) {
  const auto sizes_of_folders = std::make_shared<std::map<fs::path, std::optional<ImageSize>>>();
  return [=](const PosedPhotograph& photograph) {
    const fs::path file = images ? *images / photograph.name : scene / photograph.file;
    try {
      return photograph_size(file, Orientation::as_stored);
    } catch (const InputError&) {
      const auto [entry, is_new] = sizes_of_folders->try_emplace(file.parent_path());
      if (is_new) entry->second = some_size_in(entry->first);
      if (!entry->second) throw;
      return *entry->second;
    }
  };
}

PhotographLookup photographs_of(const CaptureRequest& request) {
  const fs::path& scene = request.scene;
  const std::optional<fs::path>& images = request.images;
  std::error_code ignored;
  const fs::path below = fs::is_directory(scene / "images", ignored) ? "images" : "";
  const fs::path folder = images.value_or(scene / below);
  const auto names = std::make_shared<const PhotographNames>(pictures_in(folder));
  PhotographLookup lookup;
  lookup.find = [=](std::string_view label) {
    const std::string name = names->find_by_path(label);
    if (!inner_path(name)) throw InputError("the photograph " + in_quotes(label) + " is no path to a file");
    PosedPhotograph photograph{name};
    photograph.file = below / photograph.name;
    return photograph;
  };
  lookup.size_of = sizes_in(scene, images);
  lookup.bad = request.bad;
  return lookup;
}

}  // namespace lumatlas
