// SPDX-License-Identifier: GPL-3.0-or-later
// Source: Erat et al. 2019, section 3.1. Kept plain: shaders/blend.frag is tested against it, line by line the same.
#include "blend/reference.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <stdexcept>

#include "atlas/srgb.h"
#include "blend/cell_shares.h"
#include "blend/exposure.h"

namespace lumatlas {

namespace {

// Linear colour and mask, both interpolated.
struct Sample {
  glm::dvec3 color{0.0};
  double validity = 0;
};

struct WeightedColor {
  double weight = 0;
  glm::dvec3 color{0.0};
};

// Before its gain: bilinear between pixel centres, held at the image's border.
Sample bilinear(const StoredView& view, const glm::dvec2& image) {
  const auto& linear = linear_from_srgb8();
  const glm::dvec2 last(view.camera.width - 1.0, view.camera.height - 1.0);
  const glm::dvec2 at = glm::clamp(image - 0.5, glm::dvec2(0), last);
  const glm::dvec2 base = glm::floor(at);
  const glm::dvec2 f = at - base;
  Sample sample;
  for (const glm::dvec2& corner : {glm::dvec2(0, 0), glm::dvec2(1, 0), glm::dvec2(0, 1), glm::dvec2(1, 1)}) {
    const auto x = static_cast<std::size_t>(std::min(base.x + corner.x, last.x));
    const auto y = static_cast<std::size_t>(std::min(base.y + corner.y, last.y));
    const double weight = (corner.x > 0 ? f.x : 1 - f.x) * (corner.y > 0 ? f.y : 1 - f.y);
    const std::size_t pixel = y * view.camera.width + x;
    const std::uint8_t* rgb = &view.photograph.rgb[3 * pixel];
    sample.color += weight * glm::dvec3(linear[rgb[0]], linear[rgb[1]], linear[rgb[2]]);
    sample.validity += weight * view.validity[pixel] / 255.0;
  }
  return sample;
}

double geometric_weight(const glm::dvec3& world, const glm::dvec3& novel_center, const glm::dvec3& stored_center,
                        const BlendOptions& options) {
  const double o = glm::length(novel_center - world);
  const double i = glm::length(stored_center - world);
  if (!(o > 0 && i > 0)) return 0;
  const double w_dir = std::max(0.0, glm::dot(novel_center - world, stored_center - world) / (o * i));
  const double w_pos =
      options.position == BlendOptions::Position::printed ? std::max(0.0, 1 - o / i) : std::min(o, i) / std::max(o, i);
  return options.lambda * w_dir + (1 - options.lambda) * w_pos;
}

WeightedColor color_in_view(const Snapshot& snapshot, std::uint32_t slot, const glm::dvec3& world,
                            const glm::dvec3& novel_center, const BlendOptions& options) {
  const StoredView& view = *snapshot.views[slot];
  const double weight = geometric_weight(world, novel_center, view.camera.center(), options);
  const glm::dvec3 cam = view.camera.cam_from_world(world);
  if (cam.z <= 0) return {};
  const glm::dvec2 image = view.camera.image_from_cam(cam);
  const glm::dvec2 size(view.camera.width, view.camera.height);
  if (!(image.x >= 0 && image.y >= 0 && image.x < size.x && image.y < size.y)) return {};
  const std::size_t pixel = static_cast<std::size_t>(image.y) * view.camera.width + static_cast<std::size_t>(image.x);
  if (cam.z > view.depth[pixel] * (1 + options.occlusion_tolerance)) return {};
  const Sample sample = bilinear(view, image);
  return {weight * sample.validity, snapshot.gains[slot] * sample.color};
}

// The K best views' mean colour, by their weights above the next best one's. False where no view is valid.
bool blend(const Snapshot& snapshot, std::span<const std::uint32_t> slots, const glm::dvec3& world,
           const glm::dvec3& novel_center, const BlendOptions& options, glm::dvec3& color) {
  std::array<WeightedColor, kMaxBlendedViews + 1> best{};
  const std::size_t kept = options.views + 1;
  for (const std::uint32_t slot : slots) {
    WeightedColor next = color_in_view(snapshot, slot, world, novel_center, options);
    for (std::size_t rank = 0; rank < kept; ++rank) {
      if (next.weight > best[rank].weight) std::swap(next, best[rank]);
    }
  }
  if (!(best[0].weight > 0)) return false;
  const double threshold = options.fade_last ? best[options.views].weight : 0;
  double total = 0;
  glm::dvec3 sum(0);
  for (std::size_t rank = 0; rank < options.views; ++rank) {
    const double weight = best[rank].weight > 0 ? best[rank].weight - threshold : 0;
    total += weight;
    sum += weight * best[rank].color;
  }
  // All K + 1 weigh the same: nothing is left above the last, and the best one stands for them.
  color = total > 0 ? sum / total : best[0].color;
  return true;
}

// Barycentric coordinates of a point on a face, each in [0, 1], sum 1; those of its first corner if it has no area.
glm::dvec3 corner_weights(const Mesh& mesh, std::uint32_t face, const glm::dvec3& world) {
  const glm::uvec3 corners = mesh.faces[face];
  const glm::dvec3 a(mesh.positions[corners.x]);
  const glm::dvec3 b(mesh.positions[corners.y]);
  const glm::dvec3 c(mesh.positions[corners.z]);
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double area = glm::dot(normal, normal);
  if (!(area > 0)) return {1, 0, 0};
  const double y = glm::dot(glm::cross(world - a, c - a), normal) / area;
  const double z = glm::dot(glm::cross(b - a, world - a), normal) / area;
  const glm::dvec3 weights = glm::clamp(glm::dvec3(1 - y - z, y, z), 0.0, 1.0);
  return weights / (weights.x + weights.y + weights.z);
}

glm::dvec3 vertex_color(const Snapshot& snapshot, std::uint32_t face, const glm::dvec3& weights) {
  const auto& linear = linear_from_srgb8();
  glm::dvec3 color(0);
  for (int corner = 0; corner < 3; ++corner) {
    const glm::u8vec3 srgb = snapshot.vertex_colors[snapshot.surface->mesh.faces[face][corner]];
    color += weights[corner] * glm::dvec3(linear[srgb.r], linear[srgb.g], linear[srgb.b]);
  }
  return color;
}

// What is the same for every pixel of a picture.
struct Picture {
  const Snapshot& snapshot;
  const Camera& camera;
  const VisibilityBuffer& visible;
  const BlendOptions& options;
  glm::dvec3 exposure;
  CellShares shares;
};

glm::dvec4 shares_at(const CellShares& shares, std::uint32_t face, const glm::dvec3& weights) {
  glm::dvec4 sum(0);
  for (int corner = 0; corner < 3; ++corner) {
    sum += weights[corner] * glm::dvec4(shares.corners[face][static_cast<std::size_t>(corner)]);
  }
  return sum;
}

// The mean of what the cells of a face make of a point on it, by their shares. False where no view of any is valid.
bool blend_cells(const Picture& picture, std::uint32_t face, const glm::dvec4& shares, const glm::dvec3& world,
                 glm::dvec3& color) {
  const Snapshot& snapshot = picture.snapshot;
  const CellShares::Zone& zone = picture.shares.zones[picture.shares.zone_of_face[face]];
  double total = 0;
  glm::dvec3 sum(0);
  for (int i = 0; i < static_cast<int>(kCellsPerZone); ++i) {
    if (!(shares[i] > 0)) continue;
    glm::dvec3 of_cell;
    const auto slots = snapshot.references.of_cell(zone[static_cast<std::size_t>(i)]);
    if (!blend(snapshot, slots, world, picture.camera.center(), picture.options, of_cell)) continue;
    total += shares[i];
    sum += shares[i] * of_cell;
  }
  color = sum / total;
  return total > 0;
}

void shade(const Picture& picture, std::size_t pixel, Rendering& rendering) {
  const std::uint32_t face = picture.visible.face[pixel];
  if (face == kNoFace) return;
  const Camera& camera = picture.camera;
  const Snapshot& snapshot = picture.snapshot;
  const std::size_t x = pixel % camera.width;
  const std::size_t y = pixel / camera.width;
  const glm::dvec2 image(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
  const glm::dvec3 world = camera.center() + static_cast<double>(picture.visible.depth[pixel]) * camera.ray(image);
  const glm::dvec3 weights = corner_weights(snapshot.surface->mesh, face, world);
  glm::dvec3 color;
  if (blend_cells(picture, face, shares_at(picture.shares, face, weights), world, color)) {
    rendering.state[pixel] = PixelState::textured;
  } else {
    color = vertex_color(snapshot, face, weights);
    const std::uint32_t cell = snapshot.surface->cells.cell_of_face[face];
    rendering.state[pixel] = snapshot.cell_seen[cell] ? PixelState::untextured : PixelState::unseen;
  }
  for (int channel = 0; channel < 3; ++channel) {
    rendering.picture.rgb[3 * pixel + static_cast<std::size_t>(channel)] =
        srgb8_from_linear(picture.exposure[channel] * color[channel]);
  }
}

}  // namespace

Rendering render_reference(const Snapshot& snapshot, const Camera& camera, const VisibilityBuffer& visible,
                           const BlendOptions& options) {
  check(options);
  check(camera);
  if (visible.width != camera.width || visible.height != camera.height) {
    throw std::invalid_argument("reference renderer: the visibility buffer must be as large as the camera's image");
  }
  const Picture picture{snapshot,
                        camera,
                        visible,
                        options,
                        picture_exposure(NearbyExposure(snapshot), camera, options),
                        share_cells(*snapshot.surface, options.border_width * snapshot.surface->cells.size)};
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  Rendering rendering;
  rendering.picture.width = camera.width;
  rendering.picture.height = camera.height;
  rendering.picture.rgb.assign(3 * pixels, 0);
  rendering.state.assign(pixels, PixelState::empty);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pixels, 1024),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t pixel = range.begin(); pixel != range.end(); ++pixel) {
                        shade(picture, pixel, rendering);
                      }
                    });
  return rendering;
}

}  // namespace lumatlas
