// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/surface_color.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <stdexcept>
#include <string>

#include "atlas/srgb.h"
#include "mesh/base/number_text.h"
#include "mesh/joined_faces.h"

namespace lumatlas {

namespace {

using glm::vec3;

// A view that is trusted less than this counts less than the colours of the mesh's vertices, which stand in where no
// view is left.
constexpr float kLeastWeight = 1e-4f;

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

// What one view shows of a place.
struct Shown {
  vec3 color, smooth, root;  // root: square root of `smooth`
  float base, detail, agreement;
};

// Sets how far each view agrees with the others: see r_i in the header.
void find_agreement(std::vector<Shown>& shown, float tolerance) {
  constexpr int kRounds = 4;
  constexpr float kSpreads = 2;  // a view this many times the spread away from the mean has a quarter of its weight
  for (int round = 0; round < kRounds; ++round) {
    vec3 mean(0);
    float weight = 0, squares = 0;
    for (const Shown& view : shown) {
      mean += view.base * view.agreement * view.root;
      weight += view.base * view.agreement;
    }
    mean /= weight;
    const auto squared_distance = [&](const Shown& view) { return glm::dot(view.root - mean, view.root - mean); };
    for (const Shown& view : shown) squares += view.base * view.agreement * squared_distance(view);
    const float t2 = tolerance * tolerance + kSpreads * kSpreads * squares / weight;
    for (Shown& view : shown) {
      const float r = 1 / (1 + squared_distance(view) / t2);
      view.agreement = r * r;
    }
  }
}

}  // namespace

void check(const ColorOptions& options) {
  if (!(options.sharpness >= 0 && options.sharpness <= 16)) {
    throw std::invalid_argument("texture: sharpness is " + number_text(options.sharpness) + ", must be in [0, 16]");
  }
  if (!(options.tolerance > 0 && std::isfinite(options.tolerance))) {
    throw std::invalid_argument("texture: tolerance is " + number_text(options.tolerance) +
                                ", must be finite and above 0");
  }
}

SurfaceColors::SurfaceColors(const Snapshot& snapshot, const TextureViews& views, const ColorOptions& options)
    : snapshot_(snapshot),
      views_(views),
      sharpness_(static_cast<float>(options.sharpness)),
      tolerance_(static_cast<float>(options.tolerance)),
      normals_(smooth_normals(snapshot.surface->mesh)) {
  check(options);
}

SurfaceColor SurfaceColors::at(std::uint32_t face, float b, float c, double density) const {
  const Mesh& mesh = snapshot_.surface->mesh;
  const glm::uvec3& f = mesh.faces[face];
  const float a = 1 - b - c;
  const vec3 point = a * mesh.positions[f.x] + b * mesh.positions[f.y] + c * mesh.positions[f.z];
  const vec3 normal = a * normals_[f.x] + b * normals_[f.y] + c * normals_[f.z];
  const float normal_length = std::max(glm::length(normal), 1e-6f);
  thread_local std::vector<Shown> shown;
  shown.clear();
  const std::uint32_t cell = snapshot_.surface->cells.cell_of_face[face];
  float total = 0;
  for (std::uint32_t i = views_.first_seen[cell]; i < views_.first_seen[cell + 1]; ++i) {
    const TextureView& view = views_.views[views_.seen_by[i]];
    TextureView::Place place;
    if (!view.sees(point, place)) continue;
    const vec3 towards = view.center() - point;
    // Both sides of a face are seen, so the angle is to either normal.
    const float cosine = std::abs(glm::dot(normal, towards)) / (normal_length * std::max(glm::length(towards), 1e-20f));
    const float pixels_per_texel = view.focal_px() / place.depth / static_cast<float>(density);
    const ViewColor color = view.sharp(place.image, pixels_per_texel);
    const float quality = cosine * std::min(pixels_per_texel, 1.0f);
    const float base = color.trust * quality * quality;
    if (!(base > 0)) continue;
    const vec3 smooth = view.smooth(place.image);
    shown.push_back({color.color, smooth, glm::sqrt(smooth), base, base * std::pow(quality, sharpness_), 1});
    total += base;
  }
  const auto& linear = linear_from_srgb8();
  const auto vertex = [&](std::uint32_t v) {
    const glm::u8vec3& rgb = snapshot_.vertex_colors[v];
    return vec3(linear[rgb.r], linear[rgb.g], linear[rgb.b]);
  };
  const vec3 stand_in = a * vertex(f.x) + b * vertex(f.y) + c * vertex(f.z);
  if (!(total > 0)) return {stand_in, false};
  find_agreement(shown, tolerance_);
  vec3 broad(0), detail(0);
  float broad_weight = 0, detail_weight = 0;
  for (const Shown& view : shown) {
    broad += view.base * view.agreement * view.smooth;
    broad_weight += view.base * view.agreement;
    detail += view.detail * view.agreement * (view.color - view.smooth);
    detail_weight += view.detail * view.agreement;
  }
  vec3 color = broad / broad_weight;
  if (detail_weight > 0) color += detail / detail_weight;
  color = (total * glm::max(color, vec3(0)) + kLeastWeight * stand_in) / (total + kLeastWeight);
  return {color, total > kLeastWeight};
}

}  // namespace lumatlas
