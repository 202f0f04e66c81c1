// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/textured_picture.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "atlas/images/srgb.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kSamples = 2;  // a pixel along a side
constexpr std::uint32_t kMostLevels = 6;

}  // namespace

TexturedPicture::TexturedPicture(const TexturedMesh& mesh)
    : mesh_(mesh), visibility_(make_ray_visibility(mesh.mesh())) {
  facts_ = mesh.bake([&](std::uint32_t, const Photograph& picture) {
    std::vector<Level>& levels = pages_.emplace_back();
    levels.push_back({picture.width, picture.rgb});
    while (levels.size() < kMostLevels && levels.back().side % 2 == 0) levels.push_back(coarser(levels.back()));
  });
}

TexturedPicture::Level TexturedPicture::coarser(const Level& fine) {
  const auto& linear = linear_from_srgb8();
  Level coarse{fine.side / 2, std::vector<std::uint8_t>(3 * std::size_t{fine.side / 2} * (fine.side / 2))};
  tbb::parallel_for(std::uint32_t{0}, coarse.side, [&](std::uint32_t y) {
    for (std::size_t x = 0; x < coarse.side; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t above = 3 * (std::size_t{2 * y} * fine.side + 2 * x) + c, below = above + 3 * fine.side;
        const float sum = linear[fine.rgb[above]] + linear[fine.rgb[above + 3]] + linear[fine.rgb[below]] +
                          linear[fine.rgb[below + 3]];
        coarse.rgb[3 * (std::size_t{y} * coarse.side + x) + c] = srgb8_from_linear(static_cast<double>(sum) / 4);
      }
    }
  });
  return coarse;
}

glm::vec3 TexturedPicture::between_texels(const Level& level, const glm::vec2& uv) {
  const auto& linear = linear_from_srgb8();
  const auto last = static_cast<float>(level.side - 1);
  const glm::vec2 at = glm::clamp(uv * static_cast<float>(level.side) - 0.5f, 0.0f, last);
  const glm::vec2 base = glm::floor(at);
  const glm::vec2 f = at - base;
  glm::vec3 sum(0);
  for (int corner = 0; corner < 4; ++corner) {
    const bool right = corner % 2 == 1, below = corner / 2 == 1;
    const auto x = static_cast<std::size_t>(std::min(base.x + (right ? 1.0f : 0.0f), last));
    const auto y = static_cast<std::size_t>(std::min(base.y + (below ? 1.0f : 0.0f), last));
    const std::uint8_t* rgb = &level.rgb[3 * (y * level.side + x)];
    sum +=
        (right ? f.x : 1 - f.x) * (below ? f.y : 1 - f.y) * glm::vec3(linear[rgb[0]], linear[rgb[1]], linear[rgb[2]]);
  }
  return sum;
}

glm::vec3 TexturedPicture::sample(FaceId face, const glm::dvec3& point, double sample_size) const {
  const std::uint32_t chart = mesh_.chart_of_face()[face];
  const ChartPlace& place = mesh_.layout().places[chart];
  const glm::vec2 uv = mesh_.layout().uv(mesh_.charts()[chart], place, point);
  const std::vector<Level>& levels = pages_[place.page];
  const double level =
      std::clamp(std::log2(std::max(sample_size * place.density, 1.0)), 0.0, static_cast<double>(levels.size() - 1));
  const auto fine = static_cast<std::size_t>(level);
  const auto share = static_cast<float>(level - static_cast<double>(fine));
  const glm::vec3 color = between_texels(levels[fine], uv);
  return share > 0 ? glm::mix(color, between_texels(levels[fine + 1], uv), share) : color;
}

Rendering TexturedPicture::render(const Camera& camera) const {
  const Camera finer = camera.scaled_to(kSamples * camera.width, kSamples * camera.height);
  const VisibilityBuffer visible = visibility_->trace(finer);
  Rendering rendering;
  rendering.picture = {
      camera.width, camera.height, std::vector<std::uint8_t>(3 * std::size_t{camera.width} * camera.height, 0), {}};
  rendering.state.assign(std::size_t{camera.width} * camera.height, PixelState::empty);
  tbb::parallel_for(std::uint32_t{0}, camera.height, [&](std::uint32_t y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      glm::vec4 sum(0);
      for (std::uint32_t i = 0; i < kSamples * kSamples; ++i) {
        const std::uint32_t sx = kSamples * x + i % kSamples, sy = kSamples * y + i / kSamples;
        const std::size_t at = std::size_t{sy} * finer.width + sx;
        if (visible.face[at] == FaceId::none) continue;
        const auto z = static_cast<double>(visible.depth[at]);
        const glm::dvec3 point = finer.center() + z * finer.ray({sx + 0.5, sy + 0.5});
        sum += glm::vec4(sample(visible.face[at], point, z / finer.fx), 1);
      }
      if (!(sum.w > 0)) continue;
      const std::size_t pixel = std::size_t{y} * camera.width + x;
      rendering.state[pixel] = PixelState::textured;
      for (int c = 0; c < 3; ++c) {
        rendering.picture.rgb[3 * pixel + static_cast<std::size_t>(c)] =
            srgb8_from_linear(static_cast<double>(sum[c] / sum.w));
      }
    }
  });
  return rendering;
}

}  // namespace lumatlas
