// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/errors/passer_by.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <variant>
#include <vector>

#include "tools/lab/synth/random.h"

namespace lumatlas::synth {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kTurn = 2 * std::numbers::pi;

// The colour of the clothes is saturated, as no wall is.
glm::vec3 strong_color(Random& random) {
  const auto hue = static_cast<float>(random.uniform(0, 6));
  const auto value = static_cast<float>(random.uniform(0.35, 0.7));
  const glm::vec3 wheel = glm::abs(glm::mod(glm::vec3(hue, hue + 4, hue + 2), 6.0F) - 3.0F) - 1.0F;
  return value * glm::mix(glm::vec3(1.0F), glm::clamp(wheel, 0.0F, 1.0F), 0.92F);
}

struct Person {
  dvec2 place;    // the feet's
  double floor;   // z
  double height;  // scene units
  double yaw;     // radians; the person walks towards its own +y
};

constexpr double kReach = 0.32;  // from the middle of a person of height 1.85 to its farthest part, across the floor

// Shirt and trousers are materials 0 and 1. Measures are shares of the height, as in drawing books.
std::vector<Solid> body_of(const Person& person) {
  constexpr std::int32_t kShirt = 0;
  constexpr std::int32_t kTrousers = 1;
  struct Part {
    dvec3 min, max;
    std::int32_t material;
  };
  const std::array<Part, 6> parts{{{{-0.10, 0.02, 0}, {-0.01, 0.12, 0.48}, kTrousers},
                                   {{0.01, -0.12, 0}, {0.10, -0.02, 0.48}, kTrousers},
                                   {{-0.12, -0.07, 0.48}, {0.12, 0.07, 0.82}, kShirt},
                                   {{-0.165, -0.07, 0.42}, {-0.12, 0.02, 0.8}, kShirt},
                                   {{0.12, -0.02, 0.42}, {0.165, 0.07, 0.8}, kShirt},
                                   {{-0.042, -0.052, 0.82}, {0.042, 0.052, 1}, kTrousers}}};  // a hood
  std::vector<Solid> solids;
  for (const Part& part : parts) {
    Block block;
    block.origin = dvec3(person.place, person.floor);
    block.yaw = person.yaw;
    block.parts.push_back({person.height * part.min, person.height * part.max, {}});
    block.parts[0].material.fill(part.material);
    solids.emplace_back(block);
  }
  return solids;
}

std::vector<Material> clothes(Random& random) {
  std::vector<Material> materials(2);
  for (Material& material : materials) {
    material.pattern = Pattern::plain;
    material.colors[0] = strong_color(random);
  }
  return materials;
}

// The lowest point of the rooms' air.
double floor_of(const Scene& scene) {
  const auto& rooms = std::get<Block>(scene.solids.at(0));
  double floor = std::numeric_limits<double>::infinity();
  for (const BlockPart& part : rooms.parts) floor = std::min(floor, rooms.origin.z + part.min.z);
  return floor;
}

bool in_air(const Scene& scene, const dvec3& point) {
  return contains(scene.solids[0], point) && std::none_of(scene.solids.begin() + 1, scene.solids.end(),
                                                          [&](const Solid& solid) { return contains(solid, point); });
}

// Points of the disk that a person needs: closer together than furniture is thick.
std::vector<dvec2> foothold() {
  std::vector<dvec2> points{{0, 0}};
  for (const double radius : {0.1, 0.2, kReach}) {
    const int count = static_cast<int>(std::ceil(kTurn * radius / 0.1));
    for (int i = 0; i < count; ++i) {
      points.push_back(radius * dvec2(std::cos(kTurn * i / count), std::sin(kTurn * i / count)));
    }
  }
  return points;
}

// Looked at from above the carpets to above the head, and across at every height of tables and shelves.
bool is_free_to_stand(const Scene& scene, const Tracer& tracer, const Person& person) {
  constexpr double kCarpet = 0.03;  // thickness that is stepped on
  const dvec3 base(person.place, person.floor + kCarpet);
  const dvec3 up(0, 0, person.height);
  const std::vector<dvec2> points = foothold();
  return std::all_of(points.begin(), points.end(), [&](const dvec2& offset) {
    const dvec3 foot = base + dvec3(offset, 0);
    return in_air(scene, foot) && in_air(scene, foot + up) && tracer.sees(foot, foot + up);
  });
}

Person candidate(const Scene& scene, const Camera& camera, Random& random) {
  const dvec3 ray = camera.ray({random.uniform(0.1, 0.9) * camera.width, 0.5 * camera.height});
  const dvec2 heading = glm::normalize(dvec2(ray));
  const double distance = random.uniform(1, 3);
  const double height = random.uniform(1.55, 1.85);
  return {dvec2(camera.center()) + distance * heading, floor_of(scene), height, random.uniform(0, kTurn)};
}

}  // namespace

std::optional<PasserBy> find_passer_by(const Scene& scene, const Tracer& tracer, const Camera& camera,
                                       std::uint64_t seed) {
  constexpr int kAttempts = 300;
  constexpr std::uint32_t kGlance = 64;  // pixels of the longer side, enough to dismiss most places
  Random random(seed);
  const std::vector<Material> materials = clothes(random);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Person person = candidate(scene, camera, random);
    if (!is_free_to_stand(scene, tracer, person)) continue;
    const Visitor visitor = tracer.visitor(body_of(person), materials);
    if (white_share(tracer.mask(camera.shrunk_to(kGlance), visitor)) < kLeastPasserBy) continue;
    const double share = white_share(tracer.mask(camera, visitor));
    if (share >= kLeastPasserBy) return PasserBy{visitor, share};
  }
  return std::nullopt;
}

bool is_free(const Scene& scene, const Tracer& tracer, const dvec3& center, double radius) {
  if (!in_air(scene, center)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-radius, radius}) {
      dvec3 end = center;
      end[axis] += sign;
      if (!in_air(scene, end) || !tracer.sees(center, end)) return false;
    }
  }
  return true;
}

double white_share(const Photograph& mask) {
  const auto white = static_cast<double>(std::count(mask.rgb.begin(), mask.rgb.end(), std::uint8_t{255}));
  return white / static_cast<double>(mask.rgb.size());
}

}  // namespace lumatlas::synth
