// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/panorama.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <iterator>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace lumatlas {

namespace {

constexpr double kOverlap = 1.1;  // tangent of half the angle that a face sees, of a cube's 1

struct Face {
  const char* name;
  glm::dmat3 panorama_from_view;  // columns: where the view's right, down and forward are in the panorama's camera
};

const std::array<Face, 6>& cube() {
  constexpr glm::dvec3 kRight(1, 0, 0), kDown(0, 1, 0), kForward(0, 0, 1);
  static const std::array<Face, 6> faces{{
      {"front", {kRight, kDown, kForward}},
      {"right", {-kForward, kDown, kRight}},
      {"back", {-kRight, kDown, -kForward}},
      {"left", {kForward, kDown, -kRight}},
      {"up", {kRight, kForward, -kDown}},
      {"down", {kRight, -kForward, kDown}},
  }};
  return faces;
}

// Returns the pinhole lens of the six views. In the middle of a view a pixel sees the same angle as in the panorama.
CameraModel lens_of_faces(const CameraModel& panorama) {
  const double focal_length = panorama.width / (2 * std::numbers::pi);
  const auto size = static_cast<std::uint32_t>(std::max(1.0, std::round(2 * kOverlap * focal_length)));
  const double middle = 0.5 * size;
  return {LensModel::kPinhole, size, size, {middle / kOverlap, middle / kOverlap, middle, middle}};
}

PosedPhotograph view_of(const PosedPhotograph& panorama, const Face& face) {
  PosedPhotograph view = panorama;
  view.name += std::string("/") + face.name;
  view.lens = lens_of_faces(panorama.lens);
  view.panorama = PanoramaFace{{panorama.lens.width, panorama.lens.height}, face.panorama_from_view};
  const glm::dquat view_from_panorama = glm::quat_cast(glm::transpose(face.panorama_from_view));
  view.cam_from_world_rotation = glm::normalize(view_from_panorama * panorama.cam_from_world_rotation);
  view.cam_from_world_translation = view_from_panorama * panorama.cam_from_world_translation;
  return view;
}

}  // namespace

void cut_panoramas(Capture& capture) {
  std::vector<PosedPhotograph> views;
  std::size_t panoramas = 0;
  for (PosedPhotograph& photograph : capture.photographs) {
    if (!photograph.bad.empty() || photograph.lens.model != LensModel::kEquirectangular) {
      views.push_back(std::move(photograph));
      continue;
    }
    ++panoramas;
    for (const Face& face : cube()) views.push_back(view_of(photograph, face));
  }
  capture.photographs = std::move(views);
  if (panoramas == 0) return;
  std::sort(capture.photographs.begin(), capture.photographs.end(),
            [](const PosedPhotograph& a, const PosedPhotograph& b) { return a.name < b.name; });
  capture.notes.push_back(std::to_string(panoramas) + " full panoramas are cut into six views each");
}

}  // namespace lumatlas
