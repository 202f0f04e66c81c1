// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/waiting.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numeric>
#include <vector>

namespace lumatlas {

namespace {

constexpr double kAboutAsLittle = 0.05;  // of news
constexpr double kFewestDecided = 4;     // views that may wait, however long they take
constexpr double kPaceMemory = 0.125;    // share of the last view in the mean time that a view takes

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

// Returns, of some of the views, the one to give up.
std::size_t least_useful_of(std::span<const WaitingView> views, const std::vector<std::size_t>& some) {
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t i : some) least = std::min(least, views[i].news);
  std::vector<const Camera*> cameras;
  for (const WaitingView& view : views) cameras.push_back(&view.camera);
  std::vector<std::size_t> candidates;
  for (const std::size_t i : some) {
    if (views[i].news <= least + kAboutAsLittle) candidates.push_back(i);
  }
  return nearest_to_another(cameras, candidates);
}

}  // namespace

std::size_t least_useful(std::span<const WaitingView> views) {
  std::vector<std::size_t> all(views.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return least_useful_of(views, all);
}

std::optional<std::size_t> one_too_many(std::span<const WaitingView> views, std::size_t most,
                                        std::size_t most_decided) {
  if (views.size() > most) return least_useful(views);
  std::vector<std::size_t> decided;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].for_depths) decided.push_back(i);
  }
  if (decided.size() > most_decided) return least_useful_of(views, decided);
  return std::nullopt;
}

double urgency(const WaitingView& view, LiveClock::time_point now, std::chrono::milliseconds longest_wait) {
  return view.news + ms_of(now - view.ready) / static_cast<double>(longest_wait.count());
}

void StoringPace::note_stored(const WaitingView& view, LiveClock::time_point now, const ViewsWork& work) {
  const bool came_later = view.ready > last_stored_;
  const double whole = ms_of(now - (came_later ? view.ready : last_stored_));
  const double ms = std::max(0.0, whole - (work.moves - (came_later ? view.work_before.moves : moves_then_)));
  last_stored_ = now;
  moves_then_ = work.moves;
  mean_ms_ = mean_ms_ ? (1 - kPaceMemory) * *mean_ms_ + kPaceMemory * ms : ms;
}

std::size_t StoringPace::most_decided(std::chrono::milliseconds longest_wait) const {
  constexpr double kAny = 1e9;
  if (!mean_ms_) return static_cast<std::size_t>(kAny);
  const double in_time = static_cast<double>(longest_wait.count()) / std::max(*mean_ms_, 1e-3);
  return static_cast<std::size_t>(std::clamp(in_time, kFewestDecided, kAny));
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
