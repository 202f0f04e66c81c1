// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/capture.h"

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
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr double kFarthest = 1e12;   // beyond, double precision cannot tell neighbouring cameras apart
constexpr double kMostError = 0.01;  // rotations are written with few digits by some programs

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

}  // namespace lumatlas
