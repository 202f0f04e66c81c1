// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tools/viewer/test_site.h"

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "tests/support/scenes/small_scenes.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {

namespace {

using nlohmann::json;

json camera_json(const Camera& camera) {
  json rotation = json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rotation.push_back(camera.cam_from_world_rotation[column][row]);
  }
  const glm::dvec3& t = camera.cam_from_world_translation;
  return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},      {"fy", camera.fy},
          {"cx", camera.cx},       {"cy", camera.cy},         {"rotation", rotation}, {"translation", {t.x, t.y, t.z}}};
}

}  // namespace

Snapshot site_model() {
  Snapshot snapshot = room_snapshot(kSiteViews, {}, {16, 2, 0});
  for (std::size_t i = 0; i < snapshot.gains.size(); ++i) {
    snapshot.gains[i] = glm::dvec3(1.0, 1.05, 0.95) * (0.9 + 0.02 * static_cast<double>(i));
  }
  for (std::size_t cell = 0; cell < snapshot.cell_seen.size(); ++cell) {
    snapshot.cell_deviation.push_back(0.3f * static_cast<float>(cell % 3));
  }
  return snapshot;
}

std::vector<Camera> site_cameras() {
  std::vector<Camera> result;
  for (std::size_t i = 0; i < kStoredPoses; ++i) result.push_back(room_camera(i));
  for (std::size_t i = 0; i < kNewPoses; ++i) {
    Camera camera = room_camera(i);
    const glm::dvec3 center = camera.center() + glm::dvec3(0.15, -0.1, 0.08);
    camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
    result.push_back(camera.scaled_to(150, 112));
  }
  return result;
}

SiteFile text_file(const std::string& name, const std::string& type, const std::string& text) {
  return {name, type, {text.begin(), text.end()}};
}

SiteFile cameras_file(const std::vector<Camera>& cameras) {
  json poses = json::array();
  for (const Camera& camera : cameras) poses.push_back(camera_json(camera));
  return text_file("cameras.json", "application/json", poses.dump());
}

std::vector<SiteFile> test_page_files(const std::string& html) {
  const std::string folder = LUMATLAS_TEST_PAGES "/";
  return {text_file("test.html", "text/html; charset=utf-8", bytes_of(folder + html)),
          text_file("test_page.js", "text/javascript", bytes_of(folder + "test_page.js"))};
}

std::vector<SiteFile> site_files(const Snapshot& model, std::size_t chunk_faces, std::size_t coarse_faces,
                                 std::size_t listed_views) {
  std::vector<SiteFile> files;
  SiteOptions options;
  options.photographs.format = ImageFormat::png;
  options.chunk_faces = chunk_faces;
  options.coarse_faces = coarse_faces;
  options.listed_views = listed_views;
  write_site(model, options, [&](SiteFile file) { files.push_back(std::move(file)); });
  return files;
}

SiteFile in_folder(const std::string& folder, SiteFile file) {
  file.name.insert(0, folder + "/");
  return file;
}

}  // namespace lumatlas
