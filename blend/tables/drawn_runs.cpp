// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/drawn_runs.h"

#include <algorithm>
#include <glm/glm.hpp>

#include "blend/tables/view_pyramid.h"

namespace lumatlas {

namespace {

constexpr double kRoundingOfPlaces = 1e-5;  // of the shader's points, as a share of their distance

Ball ball_of_faces(const ZoneMesh& mesh, const FaceRun& run) {
  glm::dvec3 least(mesh.positions[mesh.faces[run.first].x]);
  glm::dvec3 most = least;
  for (std::uint32_t face = run.first; face < run.first + run.count; ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 position(mesh.positions[mesh.faces[face][corner]]);
      least = glm::min(least, position);
      most = glm::max(most, position);
    }
  }
  return {(least + most) / 2.0, glm::distance(least, most) / 2};
}

}  // namespace

DrawnRuns::DrawnRuns(const ZoneMesh& mesh) {
  std::uint32_t first = 0;
  for (std::size_t shader = 0; shader < runs_.size(); ++shader) {
    const std::uint32_t end = first + static_cast<std::uint32_t>(mesh.face_counts.at(shader));
    while (first < end) {
      const FaceRun run{first, std::min(kFacesOfRun, end - first)};
      runs_.at(shader).push_back({run, ball_of_faces(mesh, run)});
      first += run.count;
    }
  }
}

DrawnRuns::OfShaders DrawnRuns::in_view(const Camera& camera) const {
  const ViewPyramid pyramid = view_pyramid(camera);
  OfShaders seen;
  for (std::size_t shader = 0; shader < runs_.size(); ++shader) {
    std::vector<FaceRun>& of_shader = seen.at(shader);
    for (const Run& run : runs_.at(shader)) {
      // A little more than the ball, because the shader rounds.
      const glm::dvec3 center = camera.cam_from_world(run.ball.center);
      if (outside(pyramid, center, run.ball.radius + kRoundingOfPlaces * glm::length(center))) continue;
      if (!of_shader.empty() && of_shader.back().first + of_shader.back().count == run.faces.first) {
        of_shader.back().count += run.faces.count;
      } else {
        of_shader.push_back(run.faces);
      }
    }
  }
  return seen;
}

}  // namespace lumatlas
