// SPDX-License-Identifier: GPL-3.0-or-later
// A wall with a gap, and photographs that show what is in the gap. The depth of both is known.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "tests/support/scenes/wall_scenes.h"
#include "tools/pipeline/surface/far_background.h"

namespace lumatlas {

inline constexpr double kWall = 3;       // depth of the wall
inline constexpr float kHalfGap = 0.3F;  // half of the gap's width; x = 0 is its middle

inline double wall_level(double x, double y) {
  return 120 + 50 * std::sin(9 * x + 1) * std::cos(7 * y) + 30 * std::sin(23 * x + 13 * y);
}

// Adds a part of a plane from `left` to `right`, at `depth`.
inline void add_strip(float left, float right, float depth, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const float x : {left, right}) {
    for (const float y : {-9.0F, 9.0F}) mesh.positions.emplace_back(x, y, depth);
  }
  mesh.faces.emplace_back(first, first + 1, first + 2);
  mesh.faces.emplace_back(first + 2, first + 1, first + 3);
}

inline Mesh wall_with_gap() {
  Mesh mesh;
  add_strip(-9, -kHalfGap, kWall, mesh);
  add_strip(kHalfGap, 9, kWall, mesh);
  return mesh;
}

// The wall with a gap, and a surface at a depth that fills it.
inline Mesh wall_filled_at(float depth) {
  Mesh mesh = wall_with_gap();
  add_strip(-kHalfGap, kHalfGap, depth, mesh);
  return mesh;
}

struct WallLook {
  double contrast = 1;       // multiplies the texture
  double brighter = 0;       // every second photograph is brighter by this, of 1
  double gap_depth = kWall;  // depth of what photographs show in the gap
};

// Five photographs of the wall, from places beside each other.
inline std::vector<SmallPhotograph> wall_photographs(const WallLook& look = {}) {
  std::vector<SmallPhotograph> photographs;
  for (int i = 0; i < 5; ++i) {
    SmallPhotograph photograph;
    photograph.camera = forward_camera(160, 120, {0.3 * i - 0.6, 0, 0});
    for (std::uint32_t y = 0; y < 120; ++y) {
      for (std::uint32_t x = 0; x < 160; ++x) {
        const glm::dvec3 center = photograph.camera.center(), ray = photograph.camera.ray({x + 0.5, y + 0.5});
        glm::dvec3 point = center + kWall * ray;
        if (std::abs(point.x) < kHalfGap) point = center + look.gap_depth * ray;
        const double level = 120 + look.contrast * (wall_level(point.x, point.y) - 120);
        photograph.color.emplace_back(static_cast<float>(level * (i % 2 == 0 ? 1 : 1 + look.brighter)));
        photograph.valid.push_back(1);
      }
    }
    photographs.push_back(std::move(photograph));
  }
  return photographs;
}

}  // namespace lumatlas
