// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/playback/finished_model.h"

#include <chrono>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/base/elapsed.h"
#include "tools/meshing/depth/depth_mesh.h"
#include "tools/meshing/depth/scene_depth.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

namespace {

bool can_be_read(const SceneDepth& depth) {
  try {
    (void)read_depth(depth);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

void move_scene(SceneViews& scene, const glm::dvec3& offset) {
  const auto move = [&](Camera& camera) {
    camera.cam_from_world_translation += camera.cam_from_world_rotation * offset;
  };
  for (SceneView& view : scene.views) move(view.camera);
  for (SceneDepth& depth : scene.depths) move(depth.camera);
}

// Returns the surface in the stream's own coordinates.
TriangleSoup soup_of(const Surface& surface) {
  TriangleSoup soup;
  soup.positions.reserve(surface.mesh.positions.size());
  for (const glm::vec3& position : surface.mesh.positions)
    soup.positions.push_back(surface.offset + glm::dvec3(position));
  soup.faces = surface.mesh.faces;
  return soup;
}

TriangleSoup fused_surface(SceneViews& scene, const StageProgress& fusing, FinishedModel& finished) {
  std::erase_if(scene.depths, [](const SceneDepth& depth) { return !can_be_read(depth); });
  if (scene.depths.empty()) throw InputError(scene.root.string() + ": no depth image can be read");
  SceneMesh made = mesh_from_depths(scene, SceneMeshOptions{}, fusing);
  if (made.depth) finished.voxel = made.depth->voxel;
  return std::move(made.surface);
}

}  // namespace

FinishedModel finished_model(StreamedFrames frames, const BuildOptions& options, const StageProgress& fusing,
                             const BuildCallback& building) {
  FinishedModel finished;
  auto start = std::chrono::steady_clock::now();
  TriangleSoup surface = frames.surface ? soup_of(*frames.surface) : fused_surface(frames.scene, fusing, finished);
  PosedScene scene{std::move(frames.scene), std::move(frames.offered), {}};
  scene.mesh = mesh_input_of(surface, scene.views.root);
  surface = {};
  move_scene(scene.views, scene.mesh.offset);
  finished.fusing_ms = ms_since(start);
  start = std::chrono::steady_clock::now();
  finished.result = build_model(std::move(scene), options, building);
  finished.building_ms = ms_since(start);
  return finished;
}

}  // namespace lumatlas
