// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/scenes/relief_scenes.h"

#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <random>
#include <string>
#include <utility>

#include "atlas/images/srgb.h"
#include "mesh/cells/cells.h"

namespace lumatlas {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDistance = 4;

struct Wave {
  glm::dvec3 direction;  // times 2 pi over the length
  double phase;
};

// Four waves for each channel, of lengths that no two share: no shift but the right one fits.
std::array<std::array<Wave, 4>, 3> random_waves() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::array<std::array<Wave, 4>, 3> waves{};
  for (auto& of_channel : waves) {
    double length = 2.5 * (1 - 0.3 * uniform(random));
    for (Wave& wave : of_channel) {
      const double angle = 2 * kPi * uniform(random);
      wave.direction = 2 * kPi / length * glm::dvec3(std::cos(angle), std::sin(angle), 0.5);
      wave.phase = 2 * kPi * uniform(random);
      length *= 0.55;
    }
  }
  return waves;
}

double relief_depth(double x, double y) {
  return kDistance + 0.4 * std::sin(1.7 * x + 0.4) * std::cos(1.9 * y);
}

// Turned by `turn` (rotation vector, radians) and moved by `shift`, in the camera's frame.
Camera moved(const Camera& camera, const glm::dvec3& turn, const glm::dvec3& shift) {
  const double angle = glm::length(turn);
  const glm::dmat3 rotation = angle > 0 ? glm::mat3_cast(glm::angleAxis(angle, turn / angle)) : glm::dmat3(1.0);
  Camera result = camera;
  result.cam_from_world_rotation = rotation * camera.cam_from_world_rotation;
  result.cam_from_world_translation = rotation * camera.cam_from_world_translation + shift;
  return result;
}

}  // namespace

glm::dvec3 relief_color(const glm::dvec3& point) {
  static const std::array<std::array<Wave, 4>, 3> waves = random_waves();
  glm::dvec3 color(0.0);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    double sum = 0;
    for (const Wave& wave : waves[channel]) sum += std::sin(glm::dot(wave.direction, point) + wave.phase);
    color[static_cast<int>(channel)] = 0.14 + 0.1 * sum / 4;
  }
  return color;
}

Shading plain_shading() {
  return [](const glm::dvec3& point, const glm::dvec3&) { return relief_color(point); };
}

std::shared_ptr<const Surface> relief_surface(const Placement& placement) {
  constexpr std::uint32_t kColumns = 64, kRows = 48;
  const auto surface = std::make_shared<Surface>();
  Mesh& mesh = surface->mesh;
  for (std::uint32_t row = 0; row <= kRows; ++row) {
    for (std::uint32_t column = 0; column <= kColumns; ++column) {
      const double x = 8.0 * column / kColumns - 4, y = 6.0 * row / kRows - 3;
      mesh.positions.emplace_back(placement.world({x, y, relief_depth(x, y)}));
    }
  }
  for (std::uint32_t row = 0; row < kRows; ++row) {
    for (std::uint32_t column = 0; column < kColumns; ++column) {
      const std::uint32_t a = row * (kColumns + 1) + column, b = a + kColumns + 1;
      mesh.faces.emplace_back(a, b, a + 1);
      mesh.faces.emplace_back(a + 1, b, b + 1);
    }
  }
  CellOptions options;
  options.size = 0.5 * placement.scale;
  surface->cells = make_cells(mesh, options);
  return surface;
}

Camera relief_camera(const glm::dvec3& center, const glm::dvec3& target, const Placement& placement) {
  const glm::dvec3 forward = glm::normalize(target - center);
  const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), forward));
  const glm::dmat3 cam_from_relief = glm::transpose(glm::dmat3(right, glm::cross(forward, right), forward));
  Camera camera;
  camera.width = 240;
  camera.height = 180;
  camera.fx = camera.fy = 192;
  camera.cx = 121;
  camera.cy = 89;
  camera.cam_from_world_rotation = cam_from_relief * glm::transpose(placement.rotation);
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * placement.world(center));
  return camera;
}

Camera camera_on_arc(double degrees) {
  const double angle = degrees * kPi / 180;
  const glm::dvec3 middle(0, 0, kDistance);
  return relief_camera(middle + kDistance * glm::dvec3(std::sin(angle), 0, -std::cos(angle)), middle);
}

Relief::Relief(const Placement& where)
    : placement(where), surface(relief_surface(where)), visibility(make_ray_visibility(surface->mesh)) {}

Photograph Relief::photograph(const Camera& camera, const glm::dvec3& exposure, const Shading& shading) const {
  const VisibilityBuffer visible = visibility->trace(camera);
  const glm::dvec3 center = placement.relief(camera.center());
  Photograph photograph{camera.width, camera.height, {}, {}};
  photograph.rgb.assign(3 * visible.depth.size(), 0);
  for (std::size_t pixel = 0; pixel < visible.depth.size(); ++pixel) {
    if (visible.face[pixel] == FaceId::none) continue;
    const glm::dvec2 image(static_cast<double>(pixel % camera.width) + 0.5,
                           static_cast<double>(pixel / camera.width) + 0.5);
    const glm::dvec3 world = camera.center() + static_cast<double>(visible.depth[pixel]) * camera.ray(image);
    const glm::dvec3 light = exposure * shading(placement.relief(world), center);
    for (int channel = 0; channel < 3; ++channel) {
      photograph.rgb[3 * pixel + static_cast<std::size_t>(channel)] = srgb8_from_linear(light[channel]);
    }
  }
  return photograph;
}

std::vector<glm::dvec3> Relief::points(const Camera& camera, std::uint32_t columns, std::uint32_t rows) const {
  const VisibilityBuffer visible = visibility->trace(camera.scaled_to(columns + 4, rows + 4));
  std::vector<glm::dvec3> points;
  for (std::uint32_t y = 2; y < rows + 2; ++y) {
    for (std::uint32_t x = 2; x < columns + 2; ++x) {
      const auto depth = static_cast<double>(visible.depth[std::size_t{y} * visible.width + x]);
      if (!std::isfinite(depth)) continue;
      const glm::dvec2 image((x + 0.5) * camera.width / visible.width, (y + 0.5) * camera.height / visible.height);
      points.push_back(camera.center() + depth * camera.ray(image));
    }
  }
  return points;
}

Gallery::Gallery(std::uint32_t capacity) : atlas(relief.surface, capacity), views(capacity) {}

ViewSlot Gallery::add(const Camera& camera, const Photograph& photograph, const glm::dvec3& gain,
                      std::vector<std::uint8_t> trust) {
  const ViewSlot slot =
      atlas.insert(make_stored_view("view " + std::to_string(atlas.size()), camera, photograph,
                                    relief.visibility->trace(camera), ValidityOptions{}, std::move(trust)));
  atlas.set_gain(slot, gain);
  std::shared_ptr<const StoredView> view = atlas.view(slot);
  views[slot] = ComparedView{view, view->camera, Pyramid(view->photograph->span()), gain};
  std::vector<ViewSlot> slots;
  for (ViewSlot i{0}; i < atlas.capacity(); ++i) {
    if (atlas.view(i)) slots.push_back(i);
  }
  for (CellId cell{0}; cell < relief.surface->cells.cells.size(); ++cell) atlas.set_references(cell, slots);
  return slot;
}

double pose_error_px(const Camera& a, const Camera& b, const std::vector<glm::dvec3>& points) {
  double sum = 0;
  for (const glm::dvec3& point : points) {
    const glm::dvec2 off = a.image_from_cam(a.cam_from_world(point)) - b.image_from_cam(b.cam_from_world(point));
    sum += glm::dot(off, off);
  }
  return std::sqrt(sum / static_cast<double>(points.size()));
}

Camera disturbed(const Camera& camera, double px, std::uint32_t seed, const std::vector<glm::dvec3>& points) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))); };
  const double depth = camera.cam_from_world(points[points.size() / 2]).z;
  const glm::dvec3 turn = direction();
  const glm::dvec3 shift = depth * direction();
  double size = px / camera.fx;
  for (int round = 0; round < 20; ++round) {
    size *= px / pose_error_px(camera, moved(camera, size * turn, size * shift), points);
  }
  return moved(camera, size * turn, size * shift);
}

}  // namespace lumatlas
