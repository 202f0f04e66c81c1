// SPDX-License-Identifier: GPL-3.0-or-later
// A COLMAP model as a capture.
#include <string>
#include <utility>

#include "tools/scene/forms/colmap/colmap.h"

namespace lumatlas {

namespace {

PosedPhotograph photograph_of(const ColmapImage& image, const ColmapModel& model) {
  const ColmapCamera& camera = model.camera_of(image);
  PosedPhotograph photograph{image.name,  "images/" + image.name,        {},
                             camera.lens, image.cam_from_world_rotation, image.cam_from_world_translation};
  photograph.id = image.id;
  photograph.bad = image.bad.empty() ? camera.bad : image.bad;
  photograph.named_by = "image " + std::to_string(image.id) + " of " + model.images_path.string();
  photograph.sized_by = "camera " + std::to_string(camera.id) + " of " + model.cameras_path.string();
  return photograph;
}

}  // namespace

Capture read_colmap(const CaptureRequest& request) {
  const ColmapModel model = read_colmap_model(request.scene, request.bad);
  Capture capture;
  if (!model.note.empty()) capture.notes.push_back(model.note);
  for (const ColmapImage& image : model.images) capture.photographs.push_back(photograph_of(image, model));
  finish(capture, model.images_path, request.bad);
  return capture;
}

}  // namespace lumatlas
