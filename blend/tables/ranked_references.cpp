// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/ranked_references.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

#include "blend/tables/view_pyramid.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kAboveAll = std::bit_cast<std::uint32_t>(2.0F);
constexpr double kRounding = 1e-5;  // of the shader's weights, and of its points as a share of their distance

// cos(max(0, angle - widening)), the angle given by its cosine and the widening by its sine and cosine.
double widened_cosine(double cosine, double widening_sine, double widening_cosine) {
  if (cosine >= widening_cosine) return 1;
  return cosine * widening_cosine + std::sqrt(std::max(0.0, 1 - cosine * cosine)) * widening_sine;
}

}  // namespace

std::vector<Ball> balls_of_combinations(const ChunkMesh& mesh) {
  const ZoneCells& zones = mesh.zone_cells;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<glm::dvec3> least(zones.combinations.size(), glm::dvec3(kFar));
  std::vector<glm::dvec3> most(zones.combinations.size(), glm::dvec3(-kFar));
  for (std::size_t vertex = 0; vertex < mesh.zones.size(); ++vertex) {
    const std::uint32_t combination = zones.combination[mesh.zones[vertex]];
    least[combination] = glm::min(least[combination], glm::dvec3(mesh.positions[vertex]));
    most[combination] = glm::max(most[combination], glm::dvec3(mesh.positions[vertex]));
  }
  std::vector<Ball> balls(zones.combinations.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    if (least[i].x <= most[i].x) balls[i] = {(least[i] + most[i]) / 2.0, glm::distance(least[i], most[i]) / 2};
  }
  return balls;
}

double bound_of_weight(const Ball& ball, const glm::dvec3& novel_center, const glm::dvec3& stored_center,
                       const BlendOptions& options) {
  const glm::dvec3 to_novel = novel_center - ball.center;
  const glm::dvec3 to_stored = stored_center - ball.center;
  const double o = glm::length(to_novel);
  const double i = glm::length(to_stored);
  const double r = ball.radius + kRounding * o;
  double direction = 1;
  if (o > r && i > r) {
    const double sine_o = r / o, sine_i = r / i;
    const double cosine_o = std::sqrt(1 - sine_o * sine_o), cosine_i = std::sqrt(1 - sine_i * sine_i);
    const double sine = sine_o * cosine_i + cosine_o * sine_i;
    const double cosine = cosine_o * cosine_i - sine_o * sine_i;
    direction = std::max(0.0, widened_cosine(glm::dot(to_novel, to_stored) / (o * i), sine, cosine));
  }
  double position = 1;
  if (options.position == BlendOptions::Position::printed) {
    position = std::clamp(1 - std::max(0.0, o - r) / (i + r), 0.0, 1.0);
  } else if (std::min(o, i) + r < std::max(o, i) - r) {
    position = (std::min(o, i) + r) / (std::max(o, i) - r);
  }
  return options.lambda * direction + (1 - options.lambda) * position + kRounding;
}

std::vector<RankedReference> unranked(const ZoneReferences& lists) {
  std::vector<RankedReference> references;
  references.reserve(lists.references.size());
  for (const std::uint32_t reference : lists.references) references.emplace_back(reference, kAboveAll);
  return references;
}

void rank_references(const ZoneReferences& lists, std::span<const Ball> balls, const Camera& camera,
                     std::span<const std::optional<glm::dvec3>> stored_centers, const BlendOptions& options,
                     std::span<RankedReference> references) {
  const ViewPyramid pyramid = view_pyramid(camera);
  const glm::dvec3 novel_center = camera.center();
  tbb::parallel_for(std::size_t{0}, balls.size(), [&](std::size_t zone) {
    const Ball& ball = balls[zone];
    if (outside(pyramid, camera.cam_from_world(ball.center), ball.radius)) return;
    const glm::uvec2 range = lists.ranges[zone];
    const auto of_zone = references.subspan(range.x, range.y - range.x);
    for (RankedReference& reference : of_zone) {
      const std::optional<glm::dvec3>& center = stored_centers[slot_of(reference.x)];
      const double bound = center ? bound_of_weight(ball, novel_center, *center, options) : 0;
      reference.y = std::bit_cast<std::uint32_t>(static_cast<float>(bound));
    }
    // The bits of floats that are not negative are in the order of the floats.
    std::sort(of_zone.begin(), of_zone.end(),
              [](const RankedReference& a, const RankedReference& b) { return a.y != b.y ? a.y > b.y : a.x < b.x; });
  });
}

}  // namespace lumatlas
