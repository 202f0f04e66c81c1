// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/vertex_colors.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "atlas/srgb.h"
#include "mesh/spreading.h"

namespace lumatlas {

namespace {

constexpr double kOcclusionTolerance = 0.02;  // of the depth; above the mesh's own noise in MVS and RGB-D scans
constexpr std::uint8_t kMidGrey = 128;
constexpr float kRimWeight = 1e-3f;  // of pixels that may show what is behind: for vertices that no others show

constexpr std::size_t kBlock = 1024;  // vertices whose sums are made together

// Appends what a view shows at a vertex, if it shows it at all.
void add_sample(const StoredView& view, const glm::dvec3& world, std::uint32_t vertex,
                std::vector<VertexSample>& samples) {
  const glm::dvec3 cam = view.camera.cam_from_world(world);
  if (!(cam.z > 0)) return;
  const glm::dvec2 image = view.camera.image_from_cam(cam);
  if (!(image.x >= 0 && image.y >= 0 && image.x < view.camera.width && image.y < view.camera.height)) return;
  const std::size_t pixel = static_cast<std::size_t>(image.y) * view.camera.width + static_cast<std::size_t>(image.x);
  if (cam.z > view.depth[pixel] * (1 + kOcclusionTolerance) || view.validity[pixel] == 0) return;
  const std::uint8_t* const rgb = &view.photograph.rgb[3 * pixel];
  samples.push_back({vertex & 0x7fffffffu, view.at_rim(pixel) ? 1u : 0u, rgb[0], rgb[1], rgb[2], view.validity[pixel]});
}

// In ascending order of the vertices.
std::vector<VertexSample> samples_of(const StoredView& view, const Mesh& mesh) {
  const std::size_t vertices = mesh.positions.size();
  std::vector<std::vector<VertexSample>> parts((vertices + kBlock - 1) / kBlock);
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
    const std::size_t end = std::min((part + 1) * kBlock, vertices);
    for (std::size_t vertex = part * kBlock; vertex < end; ++vertex) {
      add_sample(view, glm::dvec3(mesh.positions[vertex]), static_cast<std::uint32_t>(vertex), parts[part]);
    }
  });
  std::size_t count = 0;
  for (const auto& part : parts) count += part.size();
  std::vector<VertexSample> samples;
  samples.reserve(count);
  for (const auto& part : parts) samples.insert(samples.end(), part.begin(), part.end());
  return samples;
}

// The linear colour of a sample times its weight, and the weight.
glm::vec4 weighted(const VertexSample& sample, const glm::vec3& gain) {
  const auto& linear = linear_from_srgb8();
  float weight = static_cast<float>(sample.validity) / 255.0f;
  if (sample.at_rim) weight *= kRimWeight;
  return {gain * glm::vec3(linear[sample.r], linear[sample.g], linear[sample.b]) * weight, weight};
}

glm::u8vec3 srgb_of(const glm::vec4& sum) {
  glm::u8vec3 color;
  for (int channel = 0; channel < 3; ++channel) {
    color[channel] = srgb8_from_linear(static_cast<double>(sum[channel] / sum.w));
  }
  return color;
}

// The colour of a vertex that no view has coloured.
glm::u8vec3 own_color(const Mesh& mesh, std::size_t vertex) {
  return mesh.colors.empty() ? glm::u8vec3(kMidGrey) : mesh.colors[vertex];
}

}  // namespace

VertexColorMean::VertexColorMean(const Mesh& mesh) : mesh_(mesh), sums_(mesh.positions.size(), glm::vec4(0)) {}

void VertexColorMean::add(const StoredView& view, const glm::dvec3& gain) {
  check(view);
  for (const VertexSample& sample : samples_of(view, mesh_)) sums_[sample.vertex] += weighted(sample, glm::vec3(gain));
}

std::vector<glm::u8vec3> VertexColorMean::colors() const {
  std::vector<glm::vec4> sums = sums_;
  if (mesh_.colors.empty()) spread(mesh_.faces, VertexFaces(sums.size(), mesh_.faces), sums);
  std::vector<glm::u8vec3> colors(sums.size());
  for (std::size_t vertex = 0; vertex < sums.size(); ++vertex) {
    colors[vertex] = sums[vertex].w > 0 ? srgb_of(sums[vertex]) : own_color(mesh_, vertex);
  }
  return colors;
}

const std::vector<glm::u8vec3>& VertexColors::of(const std::shared_ptr<const Surface>& surface,
                                                 std::span<const std::shared_ptr<const StoredView>> views,
                                                 std::span<const glm::dvec3> gains) {
  if (!surface) throw std::invalid_argument("vertex colours: surface is null");
  if (gains.size() != views.size()) {
    throw std::invalid_argument("vertex colours: there are " + std::to_string(gains.size()) +
                                " gains, must be one for " + "each of the " + std::to_string(views.size()) + " slots");
  }
  if (surface != surface_) begin(surface);
  follow(views, gains);
  if (std::find(marked_.begin(), marked_.end(), 1) == marked_.end()) return colors_;
  sum_marked_blocks();
  color_marked_blocks();
  if (surface_->mesh.colors.empty()) spread();
  std::fill(marked_.begin(), marked_.end(), std::uint8_t{0});
  return colors_;
}

void VertexColors::begin(const std::shared_ptr<const Surface>& surface) {
  const std::size_t vertices = surface->mesh.positions.size();
  *this = {};
  surface_ = surface;
  marked_.assign((vertices + kBlock - 1) / kBlock, 1);
  sums_.resize(vertices, glm::vec4(0));
  colors_.resize(vertices);
}

void VertexColors::follow(std::span<const std::shared_ptr<const StoredView>> views, std::span<const glm::dvec3> gains) {
  shown_.resize(views.size());
  for (std::size_t slot = 0; slot < views.size(); ++slot) {
    Shown& shown = shown_[slot];
    const bool same_view = !shown.view.owner_before(views[slot]) && !views[slot].owner_before(shown.view);
    if (same_view && (!views[slot] || shown.gain == gains[slot])) continue;
    mark_blocks_of(shown);
    if (!same_view) {
      shown.samples = views[slot] ? samples_of(*views[slot], surface_->mesh) : std::vector<VertexSample>{};
      shown.view = views[slot];
      mark_blocks_of(shown);
    }
    shown.gain = gains[slot];
  }
}

void VertexColors::mark_blocks_of(const Shown& shown) {
  for (const VertexSample& sample : shown.samples) marked_[sample.vertex / kBlock] = 1;
}

// At each vertex samples are added in ascending order of their slots, so that rounding is the same whatever came
// before.
void VertexColors::sum_marked_blocks() {
  const auto before = [](const VertexSample& sample, std::size_t vertex) { return sample.vertex < vertex; };
  tbb::parallel_for(std::size_t{0}, marked_.size(), [&](std::size_t block) {
    if (marked_[block] == 0) return;
    const std::size_t first = block * kBlock, end = std::min(first + kBlock, sums_.size());
    std::fill(sums_.begin() + static_cast<std::ptrdiff_t>(first), sums_.begin() + static_cast<std::ptrdiff_t>(end),
              glm::vec4(0));
    for (const Shown& shown : shown_) {
      const glm::vec3 gain(shown.gain);
      auto sample = std::lower_bound(shown.samples.begin(), shown.samples.end(), first, before);
      for (; sample != shown.samples.end() && sample->vertex < end; ++sample) {
        sums_[sample->vertex] += weighted(*sample, gain);
      }
    }
  });
}

void VertexColors::color_marked_blocks() {
  tbb::parallel_for(std::size_t{0}, marked_.size(), [&](std::size_t block) {
    if (marked_[block] == 0) return;
    const std::size_t end = std::min((block + 1) * kBlock, sums_.size());
    for (std::size_t vertex = block * kBlock; vertex < end; ++vertex) {
      colors_[vertex] = sums_[vertex].w > 0 ? srgb_of(sums_[vertex]) : own_color(surface_->mesh, vertex);
    }
  });
}

// Of the vertices without a colour of their own, changes only those to which another colour than before has spread.
void VertexColors::spread() {
  const auto has_none = [](const glm::vec4& sum) { return !(sum.w > 0); };
  if (std::none_of(sums_.begin(), sums_.end(), has_none)) {
    spread_.clear();
    return;
  }
  if (!faces_) faces_.emplace(sums_.size(), surface_->mesh.faces);
  const std::vector<glm::vec4> last = std::exchange(spread_, sums_);
  lumatlas::spread(surface_->mesh.faces, *faces_, spread_);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, sums_.size(), kBlock), [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t vertex = range.begin(); vertex != range.end(); ++vertex) {
          if (!has_none(sums_[vertex])) continue;
          const bool stays = marked_[vertex / kBlock] == 0 && !last.empty() && last[vertex] == spread_[vertex];
          if (stays) continue;
          colors_[vertex] = has_none(spread_[vertex]) ? glm::u8vec3(kMidGrey) : srgb_of(spread_[vertex]);
        }
      });
}

}  // namespace lumatlas
