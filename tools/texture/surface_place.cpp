// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/surface_place.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "atlas/images/srgb.h"
#include "mesh/repair/joined_faces.h"

namespace lumatlas {

namespace {

using glm::vec3;

// Unit normals of vertices, those at one place alike, averaged over their neighbours a few times: scanned surfaces are
// rough, and what counts is where the surface looks at large.
std::vector<vec3> smooth_normals(const Mesh& mesh) {
  constexpr int kRounds = 3;
  const std::vector<glm::uvec3> joined = joined_faces(mesh);
  std::vector<vec3> normals(mesh.positions.size(), vec3(0)), sums;
  for (const glm::uvec3& f : joined) {
    const vec3 area = glm::cross(mesh.positions[f.y] - mesh.positions[f.x], mesh.positions[f.z] - mesh.positions[f.x]);
    for (int c = 0; c < 3; ++c) normals[f[c]] += area;
  }
  const auto unit = [](const vec3& v) {
    const float length = glm::length(v);
    return length > 0 ? v / length : vec3(0);
  };
  for (int round = 0; round < kRounds; ++round) {
    for (vec3& normal : normals) normal = unit(normal);
    sums = normals;
    for (const glm::uvec3& f : joined) {
      const vec3 sum = normals[f.x] + normals[f.y] + normals[f.z];
      for (int c = 0; c < 3; ++c) sums[f[c]] += sum;
    }
    normals.swap(sums);
  }
  for (std::size_t face = 0; face < joined.size(); ++face) {
    for (int c = 0; c < 3; ++c) normals[mesh.faces[face][c]] = normals[joined[face][c]];
  }
  for (vec3& normal : normals) normal = unit(normal);
  return normals;
}

}  // namespace

SurfacePlaces::SurfacePlaces(const Snapshot& snapshot)
    : snapshot_(snapshot), normals_(smooth_normals(snapshot.surface->mesh)) {}

SurfacePlace SurfacePlaces::at(FaceId face, float b, float c) const {
  const Mesh& mesh = snapshot_.surface->mesh;
  const glm::uvec3& f = mesh.faces[face];
  const float a = 1 - b - c;
  const auto& linear = linear_from_srgb8();
  const auto vertex = [&](std::uint32_t v) {
    const glm::u8vec3& rgb = snapshot_.vertex_colors.get()[v];
    return vec3(linear[rgb.r], linear[rgb.g], linear[rgb.b]);
  };
  return {a * mesh.positions[f.x] + b * mesh.positions[f.y] + c * mesh.positions[f.z],
          a * normals_[f.x] + b * normals_[f.y] + c * normals_[f.z],
          a * vertex(f.x) + b * vertex(f.y) + c * vertex(f.z)};
}

vec3 SurfacePlaces::exposure(FaceId face, float b, float c) const {
  if (exposures_.empty()) return vec3(1);
  const glm::uvec3& f = snapshot_.surface->mesh.faces[face];
  return (1 - b - c) * exposures_[f.x] + b * exposures_[f.y] + c * exposures_[f.z];
}

std::optional<ShownPlace> shown_in(const TextureView& view, const SurfacePlace& place, double density,
                                   float sharpness) {
  TextureView::ImagePoint seen;
  if (!view.sees(place.point, seen)) return std::nullopt;
  return shown_in(view, place, seen, density, sharpness);
}

std::optional<ShownPlace> shown_in(const TextureView& view, const SurfacePlace& place,
                                   const TextureView::ImagePoint& seen, double density, float sharpness) {
  const vec3 towards = view.center() - place.point;
  const float normal_length = std::max(glm::length(place.normal), 1e-6f);
  // Both sides of a face are seen, so the angle is to either normal.
  const float cosine =
      std::abs(glm::dot(place.normal, towards)) / (normal_length * std::max(glm::length(towards), 1e-20f));
  const float pixels_per_texel = view.focal_px() / seen.depth / static_cast<float>(density);
  const ViewColor color = view.sharp(seen.image, pixels_per_texel);
  const float quality = cosine * std::min(pixels_per_texel, 1.0f);
  const float base = color.trust * quality * quality;
  if (!(base > 0)) return std::nullopt;
  const vec3 smooth = view.smooth(seen.image);
  return ShownPlace{color.color, smooth, glm::sqrt(smooth), base, base * std::pow(quality, sharpness)};
}

}  // namespace lumatlas
