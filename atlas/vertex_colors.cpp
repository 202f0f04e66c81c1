// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/vertex_colors.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <glm/glm.hpp>
#include <utility>

#include "atlas/atlas.h"
#include "atlas/srgb.h"
#include "mesh/vertex_faces.h"

namespace lumatlas {

namespace {

constexpr double kOcclusionTolerance = 0.02;  // of the depth; above the mesh's own noise in MVS and RGB-D scans
constexpr std::uint8_t kMidGrey = 128;
constexpr float kRimWeight = 1e-3f;  // of pixels that may show what is behind: for vertices that no others show

// Linear colour before its gain, and validity in [0, 1] of a world position in a view; zero weight where the view does
// not show it.
glm::vec4 sample(const StoredView& view, const glm::dvec3& world) {
  const glm::dvec3 cam = view.camera.cam_from_world(world);
  if (cam.z <= 0) return glm::vec4(0);
  const glm::dvec2 image = view.camera.image_from_cam(cam);
  if (!(image.x >= 0 && image.y >= 0 && image.x < view.camera.width && image.y < view.camera.height))
    return glm::vec4(0);
  const std::size_t pixel = static_cast<std::size_t>(image.y) * view.camera.width + static_cast<std::size_t>(image.x);
  if (cam.z > view.depth[pixel] * (1 + kOcclusionTolerance)) return glm::vec4(0);
  const auto& linear = linear_from_srgb8();
  const std::uint8_t* rgb = &view.photograph.rgb[3 * pixel];
  float weight = static_cast<float>(view.validity[pixel]) / 255.0f;
  if (view.at_rim(pixel)) weight *= kRimWeight;
  return {linear[rgb[0]], linear[rgb[1]], linear[rgb[2]], weight};
}

// Colours a mesh outwards from its coloured vertices, those of non-zero weight.
class Spreading {
 public:
  Spreading(const Mesh& mesh, std::vector<glm::vec4>& colors)
      : mesh_(mesh), colors_(colors), faces_(colors.size(), mesh.faces), reached_(colors.size(), 0) {
    for (std::uint32_t vertex = 0; vertex < colors.size(); ++vertex) {
      if (colors[vertex].w > 0) reach_around(vertex);
    }
  }

  // Gives each vertex next to coloured ones the mean of them; false if there is none.
  bool next_ring() {
    const std::vector<std::uint32_t> ring = std::exchange(ring_, {});
    std::vector<glm::vec4> means;
    means.reserve(ring.size());
    for (const std::uint32_t vertex : ring) means.push_back(mean_around(vertex));
    for (std::size_t i = 0; i < ring.size(); ++i) colors_[ring[i]] = means[i];
    for (const std::uint32_t vertex : ring) reach_around(vertex);
    return !ring.empty();
  }

 private:
  void reach_around(std::uint32_t vertex) {
    for (const std::uint32_t face : faces_[vertex]) {
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t neighbour = mesh_.faces[face][corner];
        if (colors_[neighbour].w > 0 || reached_[neighbour]) continue;
        reached_[neighbour] = 1;
        ring_.push_back(neighbour);
      }
    }
  }

  [[nodiscard]] glm::vec4 mean_around(std::uint32_t vertex) const {
    glm::vec4 sum(0);
    for (const std::uint32_t face : faces_[vertex]) {
      for (int corner = 0; corner < 3; ++corner) {
        const glm::vec4& color = colors_[mesh_.faces[face][corner]];
        if (color.w > 0) sum += glm::vec4(glm::vec3(color) / color.w, 1);
      }
    }
    return sum;
  }

  const Mesh& mesh_;
  std::vector<glm::vec4>& colors_;
  VertexFaces faces_;
  std::vector<std::uint8_t> reached_;
  std::vector<std::uint32_t> ring_;  // vertices without a colour that have a neighbour with one
};

void spread_colors(const Mesh& mesh, std::vector<glm::vec4>& colors) {
  Spreading spreading(mesh, colors);
  while (spreading.next_ring()) {
  }
}

}  // namespace

VertexColorMean::VertexColorMean(const Mesh& mesh) : mesh_(mesh), sums_(mesh.positions.size(), glm::vec4(0)) {}

void VertexColorMean::add(const StoredView& view, const glm::dvec3& gain) {
  const glm::vec3 scale(gain);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, sums_.size(), 4096),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t vertex = range.begin(); vertex != range.end(); ++vertex) {
                        const glm::vec4 color = sample(view, glm::dvec3(mesh_.positions[vertex]));
                        sums_[vertex] += glm::vec4(scale * glm::vec3(color) * color.w, color.w);
                      }
                    });
}

std::vector<glm::u8vec3> VertexColorMean::colors() const {
  std::vector<glm::vec4> sums = sums_;
  if (mesh_.colors.empty()) spread_colors(mesh_, sums);
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
