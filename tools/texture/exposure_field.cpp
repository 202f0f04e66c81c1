// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/exposure_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <glm/glm.hpp>
#include <span>

#include "mesh/cells/spreading.h"
#include "mesh/repair/joined_faces.h"

namespace lumatlas {

namespace {

using glm::vec3;
using glm::vec4;

// Each round takes a vertex half of the way to the mean of its neighbours.
constexpr int kSmoothings = 40;

// The mean of each vertex's neighbours over the faces, by their weights w; (0, 0, 0, 0) without any.
std::vector<vec4> around(const std::vector<glm::uvec3>& faces, const std::vector<vec4>& values) {
  std::vector<vec4> sums(values.size(), vec4(0));
  for (const glm::uvec3& f : faces) {
    sums[f.x] += values[f.y] + values[f.z];
    sums[f.y] += values[f.z] + values[f.x];
    sums[f.z] += values[f.x] + values[f.y];
  }
  for (vec4& sum : sums) sum = sum.w > 0 ? sum / sum.w : vec4(0);
  return sums;
}

}  // namespace

ExposureField::ExposureField(const Mesh& mesh) : mesh_(mesh), sums_(mesh.positions.size(), vec4(0)) {}

void ExposureField::add(const TextureView& view) {
  const vec4 exposure(view.log_exposure(), 1);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, sums_.size(), 4096),
                    [&](const tbb::blocked_range<std::size_t>& vertices) {
                      const auto points = std::span(mesh_.positions).subspan(vertices.begin(), vertices.size());
                      for_each_seen(view, points, [&](std::size_t i, const TextureView::ImagePoint& place) {
                        sums_[vertices.begin() + i] += view.sharp(place.image, 1).trust * exposure;
                      });
                    });
}

std::vector<vec3> ExposureField::factors() const {
  const std::vector<glm::uvec3> joined = joined_faces(mesh_);
  std::vector<std::uint32_t> first_at(sums_.size());  // the vertex that stands for all at its place
  for (std::uint32_t v = 0; v < first_at.size(); ++v) first_at[v] = v;
  for (std::size_t face = 0; face < joined.size(); ++face) {
    for (int c = 0; c < 3; ++c) first_at[mesh_.faces[face][c]] = joined[face][c];
  }
  std::vector<vec4> values(sums_.size(), vec4(0));
  vec4 all(0);
  for (std::size_t v = 0; v < sums_.size(); ++v) {
    if (sums_[v].w > 0) values[first_at[v]] = sums_[v] / sums_[v].w;
    if (sums_[v].w > 0) all += sums_[v] / sums_[v].w;
  }
  spread(joined, VertexFaces(values.size(), joined), values);
  for (vec4& value : values) value = value.w > 0 ? value / value.w : vec4(0);
  for (int round = 0; round < kSmoothings; ++round) {
    const std::vector<vec4> neighbours = around(joined, values);
    for (std::size_t v = 0; v < values.size(); ++v) {
      if (neighbours[v].w > 0) values[v] = 0.5f * (values[v] + neighbours[v]);
    }
  }
  const vec3 mean = all.w > 0 ? vec3(all) / all.w : vec3(0);
  std::vector<vec3> factors;
  for (std::size_t v = 0; v < values.size(); ++v) {
    const vec4& value = values[first_at[v]];
    factors.push_back(glm::exp(value.w > 0 ? vec3(value) : mean));
  }
  return factors;
}

}  // namespace lumatlas
