// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/paths/kept_path.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "mesh/base/median.h"
#include "mesh/upright.h"
#include "tools/picture/paths/camera_tours.h"

namespace lumatlas {

namespace {

using glm::dvec3;

// The position and direction of a camera; `up` fixes the turn about that direction.
struct Gaze {
  dvec3 position, direction;
};

Gaze gaze_of(const Vantage& vantage) {
  return {vantage.position, glm::transpose(glm::mat3_cast(vantage.cam_from_world))[2]};
}

Gaze gaze_of(const Camera& camera) {
  return {camera.center(), camera.viewing_direction()};
}

Vantage vantage_of(const Gaze& gaze, const dvec3& up, double fov_deg) {
  return {gaze.position, look_at(gaze.position, gaze.position + gaze.direction, up), fov_deg};
}

// Moving by `depth` is as far as turning by a radian.
double distance_between(const Gaze& a, const Gaze& b, double depth) {
  const double turn = std::acos(std::clamp(glm::dot(a.direction, b.direction), -1.0, 1.0));
  return glm::distance(a.position, b.position) / depth + turn;
}

// Returns the median distance of a camera to the nearest other one: shorter steps between cameras would be jumps.
double spacing_of(const std::vector<Gaze>& cameras, double depth) {
  constexpr double kLeast = 0.02;
  std::vector<double> nearest;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < cameras.size(); ++j) {
      if (i != j) least = std::min(least, distance_between(cameras[i], cameras[j], depth));
    }
    if (std::isfinite(least)) nearest.push_back(least);
  }
  return nearest.empty() ? 1 : std::max(kLeast, percentile(std::move(nearest), 0.5));
}

Gaze between(const Gaze& from, const Gaze& to, double part) {
  const dvec3 direction = glm::mix(from.direction, to.direction, part);
  // Opposite directions have no middle: the cameras know better.
  return {glm::mix(from.position, to.position, part),
          glm::length(direction) > 1e-3 ? glm::normalize(direction) : to.direction};
}

// The cameras near a place, as one: those within `spacing` of the nearest count, the nearer the more. It moves smoothly
// with the place.
Gaze nearby_camera(const Gaze& place, const std::vector<Gaze>& cameras, double spacing, double depth) {
  std::vector<double> distances;
  for (const Gaze& camera : cameras) distances.push_back(distance_between(place, camera, depth));
  const auto nearest = std::min_element(distances.begin(), distances.end());
  Gaze sum{dvec3(0), dvec3(0)};
  double weights = 0;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const double weight = std::exp((*nearest - distances[i]) / spacing);
    sum.position += weight * cameras[i].position;
    sum.direction += weight * cameras[i].direction;
    weights += weight;
  }
  const bool has_direction = glm::length(sum.direction) > 1e-3 * weights;
  return {sum.position / weights, has_direction
                                      ? glm::normalize(sum.direction)
                                      : cameras[static_cast<std::size_t>(nearest - distances.begin())].direction};
}

// Returns the part of the way to its target, 0 to 1, after which a frame is covered; if none is, where it sees most.
double pull_needed(const Vantage& frame, const Gaze& target, const dvec3& up, double enough,
                   const PhotographedShare& share) {
  constexpr int kSteps = 8;
  double best = 0, most = share(frame);
  for (int step = 1; step <= kSteps && most < enough; ++step) {
    const double part = static_cast<double>(step) / kSteps;
    const double seen = share(vantage_of(between(gaze_of(frame), target, part), up, frame.fov_deg));
    if (seen <= most) continue;
    most = seen;
    best = part;
  }
  return best;
}

// Each value at least what it was, with no step between neighbours: the greatest of a neighbourhood, then the mean of
// the greatest.
std::vector<double> smoothed(const std::vector<double>& values, bool closed) {
  const auto count = static_cast<std::ptrdiff_t>(values.size());
  const std::ptrdiff_t reach = std::max<std::ptrdiff_t>(1, count / 24);
  const auto over_neighbours = [&](const std::vector<double>& of, bool greatest) {
    std::vector<double> result(of.size());
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      double sum = 0, most = 0;
      for (std::ptrdiff_t j = i - reach; j <= i + reach; ++j) {
        const std::ptrdiff_t k = closed ? ((j % count) + count) % count : std::clamp<std::ptrdiff_t>(j, 0, count - 1);
        const double value = of[static_cast<std::size_t>(k)];
        sum += value;
        most = std::max(most, value);
      }
      result[static_cast<std::size_t>(i)] = greatest ? most : sum / static_cast<double>(2 * reach + 1);
    }
    return result;
  };
  return over_neighbours(over_neighbours(values, true), false);
}

// The share from which on a frame is covered.
double enough_of(std::span<const Camera> stored, const dvec3& up, double fov_deg, const PhotographedShare& share) {
  constexpr std::size_t kMostLooks = 60;
  const std::size_t step = (stored.size() + kMostLooks - 1) / kMostLooks;
  std::vector<double> shares;
  for (std::size_t i = 0; i < stored.size(); i += step) {
    shares.push_back(share(vantage_of(gaze_of(stored[i]), up, fov_deg)));
  }
  return kCoveredShare * percentile(std::move(shares), 0.5);
}

double covered_share(const std::vector<Vantage>& path, double enough, const PhotographedShare& share) {
  const auto covered =
      std::count_if(path.begin(), path.end(), [&](const Vantage& frame) { return share(frame) >= enough; });
  return path.empty() ? 0 : static_cast<double>(covered) / static_cast<double>(path.size());
}

// The longest run of covered places of a circle; its length is 0 where none is, and all of them where all are.
struct Run {
  std::size_t first = 0, length = 0;
};

Run longest_run(const std::vector<bool>& covered) {
  Run longest;
  for (std::size_t first = 0; first < covered.size(); ++first) {
    std::size_t length = 0;
    while (length < covered.size() && covered[(first + length) % covered.size()]) ++length;
    if (length > longest.length) longest = {first, length};
  }
  return longest;
}

// To the end of an arc of the circle and back, in turns.
std::vector<double> swing(double from, double arc, std::size_t frames) {
  std::vector<double> turns;
  for (std::size_t i = 0; i < frames; ++i) {
    const double phase = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(frames);
    turns.push_back(from + arc * (1 - std::cos(phase)) / 2);
  }
  return turns;
}

}  // namespace

KeptPath keep_to_photographs(const std::vector<Vantage>& path, std::span<const Camera> stored, const dvec3& up,
                             double depth, bool closed, const PhotographedShare& share) {
  if (stored.empty()) throw std::invalid_argument("tour: there is no stored view, must be at least one");
  KeptPath result;
  if (path.empty()) return result;
  std::vector<Gaze> cameras;
  for (const Camera& camera : stored) cameras.push_back(gaze_of(camera));
  const double spacing = spacing_of(cameras, depth);
  const double enough = enough_of(stored, up, path.front().fov_deg, share);
  std::vector<Gaze> targets;
  std::vector<double> pulls;
  for (const Vantage& frame : path) {
    targets.push_back(nearby_camera(gaze_of(frame), cameras, spacing, depth));
    pulls.push_back(pull_needed(frame, targets.back(), up, enough, share));
  }
  pulls = smoothed(pulls, closed);
  for (std::size_t i = 0; i < path.size(); ++i) {
    const bool stays = pulls[i] == 0;
    if (!stays) ++result.moved;
    result.vantages.push_back(stays ? path[i]
                                    : vantage_of(between(gaze_of(path[i]), targets[i], pulls[i]), up, path[i].fov_deg));
  }
  result.covered_before = covered_share(path, enough, share);
  result.covered = covered_share(result.vantages, enough, share);
  return result;
}

KeptPath kept_orbit(std::span<const Camera> stored, double depth, std::size_t frames, double fov_deg,
                    const PhotographedShare& share) {
  constexpr std::size_t kLooks = 120;                                         // around the circle
  const std::vector<Vantage> circle = orbit(stored, depth, frames, fov_deg);  // refuses where no view is stored
  const dvec3 up = upward(stored);
  const double enough = enough_of(stored, up, fov_deg, share);
  std::vector<bool> covered;
  for (const Vantage& place : orbit(stored, depth, kLooks, fov_deg)) covered.push_back(share(place) >= enough);
  const Run run = longest_run(covered);
  if (run.length < 2 || run.length == kLooks) return keep_to_photographs(circle, stored, up, depth, true, share);
  const double arc = static_cast<double>(run.length - 1) / kLooks;
  KeptPath result;
  result.vantages = orbit_at(stored, depth, swing(static_cast<double>(run.first) / kLooks, arc, frames), fov_deg);
  result.covered_before = covered_share(circle, enough, share);
  result.covered = covered_share(result.vantages, enough, share);
  result.moved = frames;
  result.arc_deg = 360 * arc;
  return result;
}

}  // namespace lumatlas
