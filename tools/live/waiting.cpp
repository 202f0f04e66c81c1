// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/waiting.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

namespace lumatlas {

namespace {

constexpr double kAboutAsLittle = 0.05;  // of news

// The turn between two cameras in radians, and their distance in units of `reach`.
double unlikeness(const Camera& a, const Camera& b, double reach) {
  const glm::dvec3 ahead(0, 0, 1);
  const double cosine =
      glm::dot(ahead * a.cam_from_world_rotation, ahead * b.cam_from_world_rotation);  // rows of the rotations
  return std::acos(std::clamp(cosine, -1.0, 1.0)) + glm::distance(a.center(), b.center()) / reach;
}

// The largest distance of a camera from the first, so that distances compare with turns in any unit; 1 if there is
// none.
double reach_of(const std::vector<const Camera*>& cameras) {
  double reach = 0;
  for (const Camera* camera : cameras) {
    reach = std::max(reach, glm::distance(camera->center(), cameras.front()->center()));
  }
  return reach > 0 ? reach : 1;
}

// Returns, of the candidates, the one whose camera is nearest to that of another of all, the last such.
std::size_t nearest_to_another(const std::vector<const Camera*>& cameras, const std::vector<std::size_t>& candidates) {
  const double reach = reach_of(cameras);
  double least = std::numeric_limits<double>::infinity();
  std::size_t found = candidates.back();
  for (const std::size_t candidate : candidates) {
    for (std::size_t other = 0; other < cameras.size(); ++other) {
      if (other == candidate) continue;
      const double difference = unlikeness(*cameras[candidate], *cameras[other], reach);
      if (difference > least) continue;
      least = difference;
      found = candidate;
    }
  }
  return found;
}

}  // namespace

std::size_t least_useful(std::span<const WaitingView> views) {
  double least = std::numeric_limits<double>::infinity();
  for (const WaitingView& view : views) least = std::min(least, view.news);
  std::vector<const Camera*> cameras;
  std::vector<std::size_t> candidates;
  for (std::size_t i = 0; i < views.size(); ++i) {
    cameras.push_back(&views[i].camera);
    if (views[i].news <= least + kAboutAsLittle) candidates.push_back(i);
  }
  return nearest_to_another(cameras, candidates);
}

std::size_t most_alike(std::span<const WaitingDepth> frames) {
  std::vector<const Camera*> cameras;
  std::vector<std::size_t> candidates;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    cameras.push_back(&frames[i].camera);
    candidates.push_back(i);
  }
  return nearest_to_another(cameras, candidates);
}

}  // namespace lumatlas
