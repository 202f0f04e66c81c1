// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/polycam.h"

#include <array>
#include <glm/glm.hpp>
#include <glm/mat4x4.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

#include "mesh/base/errors.h"
#include "mesh/base/whole_file.h"
#include "tools/base/strict_json.h"
#include "tools/scene/forms/fields/brown_lens.h"
#include "tools/scene/forms/fields/lens_coefficients.h"
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestSize = 65536;  // pixels
constexpr const char* kDepths = "keyframes/depth";
constexpr const char* kConfidences = "keyframes/confidence";

struct Folders {
  fs::path cameras, images;  // relative to the scene
};
const std::array<Folders, 2>& all_folders() {  // those that Polycam has corrected first
  static const std::array<Folders, 2> folders{
      {{"keyframes/corrected_cameras", "keyframes/corrected_images"}, {"keyframes/cameras", "keyframes/images"}}};
  return folders;
}

std::optional<Folders> folders_of(const fs::path& scene) {
  for (const Folders& folders : all_folders()) {
    if (!files_ending_in(scene / folders.cameras, ".json").empty()) return folders;
  }
  return std::nullopt;
}

JsonPlace field(const JsonPlace& all, const std::string& key) {
  if (!all.value().is_object() || !all.has(key)) all.refuse("has no " + key);
  return all.at(key);
}

glm::dmat4 alignment_of(const PolycamFiles& files, Capture& posed) {
  glm::dmat4 mesh_from_world(1);
  if (!files.mesh_info_text) return mesh_from_world;
  const nlohmann::json content = parse_json(*files.mesh_info_text, files.mesh_info.string());
  const JsonPlace all(files.mesh_info.string(), "", content);
  if (!content.is_object() || !all.has("alignmentTransform")) return mesh_from_world;
  const JsonPlace place = all.at("alignmentTransform");
  const std::vector<JsonPlace> values = place.elements();
  if (values.size() != 16) place.refuse("has " + std::to_string(values.size()) + " values, must have 16");
  for (std::size_t i = 0; i < 16; ++i)
    mesh_from_world[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = values[i].number();
  const auto last = [&](int column) { return mesh_from_world[column][3]; };
  try {
    check_last_row({last(0), last(1), last(2), last(3)});
  } catch (const std::invalid_argument& error) {
    place.refuse(error.what());
  }
  posed.notes.emplace_back(
      "the poses are turned by alignmentTransform of mesh_info.json, so that they are in the "
      "coordinates of raw.glb");
  return mesh_from_world;
}

CameraModel lens_in(const JsonPlace& all) {
  const auto coefficient = [&](std::string_view key) {
    return all.has(key) ? std::optional(all.at(key)) : std::nullopt;
  };
  refuse_unread_coefficients(coefficient, {});
  const auto number = [&](const char* key) { return field(all, key).number(); };
  BrownLens lens;
  lens.width = static_cast<std::uint32_t>(field(all, "width").count(1, kLargestSize));
  lens.height = static_cast<std::uint32_t>(field(all, "height").count(1, kLargestSize));
  lens.fx = number("fx");
  lens.fy = number("fy");
  lens.cx = number("cx");
  lens.cy = number("cy");
  try {
    return lens_of(lens);
  } catch (const std::invalid_argument& error) {
    all.refuse(std::string("an impossible camera: ") + error.what());
  }
}

glm::dmat4 world_from_camera(const JsonPlace& all) {
  glm::dmat4 result(1);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      result[column][row] = field(all, "t_" + std::to_string(row) + std::to_string(column)).number();
    }
  }
  return result;
}

}  // namespace

Capture parse_polycam(const PolycamFiles& files,
                      const std::function<PosedPhotograph(const std::string&)>& photograph_of) {
  Capture posed;
  std::size_t with_confidence = 0;
  const glm::dmat4 mesh_from_world = alignment_of(files, posed);
  for (const auto& [id, text] : files.frames) {
    const std::string path = (files.cameras / (id + ".json")).string();
    const nlohmann::json content = parse_json(text, path);
    const JsonPlace all(path, "", content);
    PosedPhotograph photograph = photograph_of(id);
    const glm::dmat4 mesh_from_camera = mesh_from_world * world_from_camera(all);
    const std::string broken = set_pose(photograph, glm::dmat3(mesh_from_camera), glm::dvec3(mesh_from_camera[3]),
                                        CameraAxes::right_up_backward);
    if (!broken.empty()) {
      throw InputError(path + ": its pose " + (posed.notes.empty() ? "" : "with alignmentTransform ") + broken);
    }
    photograph.lens = lens_in(all);
    if (files.depths.contains(id)) {
      posed.depths.push_back(depth_with(photograph, fs::path(kDepths) / (id + ".png"), 0.001));
      if (files.confidences.contains(id)) {
        posed.depths.back().confidence = fs::path(kConfidences) / (id + ".png");
        ++with_confidence;
      }
    }
    posed.photographs.push_back(std::move(photograph));
  }
  finish(posed, files.cameras);
  if (files.cameras.filename() == "cameras") {
    posed.notes.push_back((files.cameras.parent_path() / "corrected_cameras").string() +
                          "/ is not there: the poses are those of the tracking, which Polycam has not refined");
  }
  note_depths(posed, "taken to be in millimetres, and to show what the photographs show at another size" +
                         (with_confidence == 0 ? std::string()
                                               : "; pixels of low confidence are left out of " +
                                                     std::to_string(with_confidence) + " of them"));
  return posed;
}

std::optional<fs::path> find_polycam(const fs::path& scene) {
  const std::optional<Folders> folders = folders_of(scene);
  return folders ? std::optional(scene / folders->cameras) : std::nullopt;
}

Capture read_polycam(const CaptureRequest& request) {
  const Folders folders = folders_of(request.scene).value();
  PolycamFiles files{request.scene / folders.cameras, {}, request.scene / "mesh_info.json", std::nullopt};
  for (const fs::path& file : files_ending_in(files.cameras, ".json")) {
    files.frames.emplace_back(file.stem().string(), read_whole_file(file));
  }
  for (const fs::path& file : files_ending_in(request.scene / kDepths, ".png"))
    files.depths.insert(file.stem().string());
  for (const fs::path& file : files_ending_in(request.scene / kConfidences, ".png")) {
    files.confidences.insert(file.stem().string());
  }
  std::error_code ignored;
  if (fs::exists(files.mesh_info, ignored)) files.mesh_info_text = read_whole_file(files.mesh_info);
  const PhotographNames names(pictures_in(request.images.value_or(request.scene / folders.images)));
  return parse_polycam(files, [&](const std::string& id) {
    PosedPhotograph photograph{names.find(id + ".jpg")};
    photograph.file = folders.images / photograph.name;
    photograph.black_rim = folders.images.filename() == "corrected_images";
    return photograph;
  });
}

}  // namespace lumatlas
