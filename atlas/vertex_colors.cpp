// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/vertex_colors.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <glm/glm.hpp>

#include "atlas/atlas.h"
#include "atlas/srgb.h"

namespace lumatlas {

namespace {

constexpr double kOcclusionTolerance = 0.02;  // of the depth; above the mesh's own noise in MVS and RGB-D scans
constexpr std::uint8_t kMidGrey = 128;

// Linear colour and validity in [0, 1] of a world position in a view; zero weight where the view does not show it.
glm::vec4 sample(const StoredView& view, const glm::dvec3& world) {
  const glm::dvec3 cam = view.camera.cam_from_world(world);
  if (cam.z <= 0) return glm::vec4(0);
  const glm::dvec2 image = view.camera.image_from_cam(cam);
  if (!(image.x >= 0 && image.y >= 0 && image.x < view.camera.width && image.y < view.camera.height)) return glm::vec4(0);
  const std::size_t pixel = static_cast<std::size_t>(image.y) * view.camera.width + static_cast<std::size_t>(image.x);
  if (cam.z > view.depth[pixel] * (1 + kOcclusionTolerance)) return glm::vec4(0);
  const auto& linear = linear_from_srgb8();
  const std::uint8_t* rgb = &view.photograph.rgb[3 * pixel];
  const float gain = static_cast<float>(view.gain);
  return {gain * linear[rgb[0]], gain * linear[rgb[1]], gain * linear[rgb[2]],
          static_cast<float>(view.validity[pixel]) / 255.0f};
}

// Gives each vertex with zero weight the mean of its neighbours that have one, ring by ring.
void spread_colors(const std::vector<glm::uvec3>& faces, std::vector<glm::vec4>& colors) {
  std::vector<glm::vec4> incoming(colors.size(), glm::vec4(0));
  std::vector<glm::uvec3> open = faces;
  bool progress = true;
  while (progress) {
    progress = false;
    std::vector<glm::uvec3> still_open;
    for (const glm::uvec3& face : open) {
      glm::vec4 known(0);
      int unknown = 0;
      for (int corner = 0; corner < 3; ++corner) {
        const glm::vec4& color = colors[face[corner]];
        if (color.w > 0) {
          known += glm::vec4(glm::vec3(color) / color.w, 1);
        } else {
          ++unknown;
        }
      }
      if (unknown == 0) continue;
      still_open.push_back(face);
      if (known.w == 0) continue;
      progress = true;
      for (int corner = 0; corner < 3; ++corner) {
        if (colors[face[corner]].w == 0) incoming[face[corner]] += known;
      }
    }
    for (const glm::uvec3& face : still_open) {
      for (int corner = 0; corner < 3; ++corner) {
        if (colors[face[corner]].w == 0) colors[face[corner]] = incoming[face[corner]];
      }
    }
    open = std::move(still_open);
  }
}

}  // namespace

VertexColorMean::VertexColorMean(const Mesh& mesh) : mesh_(mesh), sums_(mesh.positions.size(), glm::vec4(0)) {}

void VertexColorMean::add(const StoredView& view) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, sums_.size(), 4096), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t vertex = range.begin(); vertex != range.end(); ++vertex) {
      const glm::vec4 color = sample(view, glm::dvec3(mesh_.positions[vertex]));
      sums_[vertex] += glm::vec4(glm::vec3(color) * color.w, color.w);
    }
  });
}

std::vector<glm::u8vec3> VertexColorMean::colors() const {
  std::vector<glm::vec4> sums = sums_;
  if (mesh_.colors.empty()) spread_colors(mesh_.faces, sums);
  std::vector<glm::u8vec3> colors(sums.size(), glm::u8vec3(kMidGrey));
  for (std::size_t vertex = 0; vertex < sums.size(); ++vertex) {
    const glm::vec4& sum = sums[vertex];
    if (sum.w > 0) {
      for (int channel = 0; channel < 3; ++channel) {
        colors[vertex][channel] = srgb8_from_linear(static_cast<double>(sum[channel] / sum.w));
      }
    } else if (!mesh_.colors.empty()) {
      colors[vertex] = mesh_.colors[vertex];
    }
  }
  return colors;
}

}  // namespace lumatlas
