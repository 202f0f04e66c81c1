// SPDX-License-Identifier: GPL-3.0-or-later
// glTF 2.0, section 3.10 (cameras): they look along -z with y upwards; a view's along z with y downwards.
#include "atlas/model/gltf/gltf_cameras.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>
#include <vector>

#include "mesh/upright.h"

namespace lumatlas {

namespace {

using nlohmann::json;

// Returns the near plane that glTF's cameras need and no input states: nearer than this, scene units, nothing is drawn.
// > 0.
double near_plane(const Mesh& mesh) {
  constexpr double kShare = 1e-3;  // share of the mesh's diagonal
  const Bounds box = bounds(mesh);
  const double diagonal = box.empty() ? 0 : glm::length(box.max - box.min);
  return diagonal > 0 ? kShare * diagonal : kShare;
}

// Returns the factor by which a picture must be wider to have the camera's principal point in its middle, the shape of
// the camera's picture, and all of that in it. >= 1.
double centred_size(const Camera& camera) {
  const auto of_side = [](double principal, double size) {
    return std::max(principal, size - principal) / (0.5 * size);
  };
  return std::max(of_side(camera.cx, camera.width), of_side(camera.cy, camera.height));
}

json camera_json(const StoredView& view, double near) {
  const Camera& camera = view.camera;
  const double half_width = 0.5 * camera.width / camera.fx, half_height = 0.5 * camera.height / camera.fy;
  return {{"name", unicode_name(view.name)},
          {"type", "perspective"},
          {"perspective",
           {{"yfov", 2 * std::atan(centred_size(camera) * half_height)},
            {"aspectRatio", half_width / half_height},
            {"znear", near}}},
          {"extras",
           {{"imageSize", {camera.width, camera.height}},
            {"focalLength", {camera.fx, camera.fy}},
            {"principalPoint", {camera.cx, camera.cy}}}}};
}

json node_json(const StoredView& view, std::size_t camera) {
  const glm::dmat3 scene_from_cam = glm::transpose(view.camera.cam_from_world_rotation);
  const glm::dvec3 center = view.camera.center();
  return {{"name", unicode_name(view.name)},
          {"camera", camera},
          {"rotation", gltf_rotation({scene_from_cam[0], -scene_from_cam[1], -scene_from_cam[2]})},
          {"translation", {center.x, center.y, center.z}}};
}

}  // namespace

std::string unicode_name(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, '?');
  const std::string quoted = json(name).dump(-1, ' ', false, json::error_handler_t::replace);
  return json::parse(quoted).get<std::string>();
}

glm::dmat3 gltf_from_scene(const Snapshot& snapshot) {
  std::vector<Camera> cameras;
  for (const auto& view : snapshot.views) {
    if (view) cameras.push_back(view->camera);
  }
  return cameras.empty() ? glm::dmat3(1) : upright(cameras, upward(cameras));
}

json gltf_rotation(const glm::dmat3& rotation) {
  const glm::dquat q = glm::normalize(glm::quat_cast(rotation));
  return {q.x, q.y, q.z, q.w};
}

void add_cameras(json& document, const Snapshot& snapshot) {
  const double near = near_plane(near_surface(*snapshot.surface).mesh);
  for (const auto& view : snapshot.views) {
    if (!view) continue;
    const std::size_t camera = document["cameras"].size();  // 0 for null
    document["cameras"].push_back(camera_json(*view, near));
    document["nodes"][0]["children"].push_back(document["nodes"].size());
    document["nodes"].push_back(node_json(*view, camera));
  }
}

}  // namespace lumatlas
