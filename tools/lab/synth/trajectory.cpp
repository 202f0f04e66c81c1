// SPDX-License-Identifier: GPL-3.0-or-later
// Places and directs the cameras of a synthetic scene.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/lab/synth/errors/passer_by.h"
#include "tools/lab/synth/kinds.h"
#include "tools/lab/synth/random.h"
#include "tools/lab/synth/synth.h"
#include "tools/lab/synth/tracer.h"
#include "tools/picture/paths/camera_tours.h"
#include "tools/picture/paths/spline.h"

namespace lumatlas::synth {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kTurn = 2 * std::numbers::pi;

// World z is up in the picture: the camera's x axis is level.
void look(Camera& camera, const dvec3& center, double heading, double pitch) {
  const dvec3 forward(std::cos(pitch) * std::cos(heading), std::cos(pitch) * std::sin(heading), std::sin(pitch));
  const dvec3 right(std::sin(heading), -std::cos(heading), 0);
  const dvec3 down = glm::cross(forward, right);
  camera.cam_from_world_rotation = glm::transpose(glm::dmat3(right, down, forward));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
}

Camera camera_without_pose(const SynthOptions& options) {
  Camera camera;
  camera.width = options.width;
  camera.height = options.height;
  camera.fx = camera.fy = 0.5 * options.width / std::tan(options.fov_deg * kTurn / 720);
  camera.cx = 0.5 * options.width;
  camera.cy = 0.5 * options.height;
  return camera;
}

// A curve by its length, without those of its pieces that cannot be passed.
class Way {
 public:
  using Curve =
      std::function<dvec3(double)>;  // a point of the piece, counted from the beginning; also between whole numbers
  using Passable = std::function<bool(const dvec3&, const dvec3&)>;  // straight from one place to the other

  Way(Curve curve, std::size_t pieces, const Passable& passable = {}) : curve_(std::move(curve)) {
    std::vector<char> open(pieces, 1);
    tbb::parallel_for(std::size_t{0}, passable ? pieces : 0,
                      [&](std::size_t i) { open[i] = passable(begin(i), begin(i + 1)) ? 1 : 0; });
    for (std::size_t i = 0; i < pieces; ++i) {
      distances_.push_back(distances_.back() + (open[i] != 0 ? glm::distance(begin(i), begin(i + 1)) : 0));
    }
  }

  [[nodiscard]] double length() const { return distances_.back(); }

  // `distance` is in [0, length()).
  [[nodiscard]] dvec3 at(double distance) const { return curve_(piece_at(distance)); }
  [[nodiscard]] dvec3 direction(double distance) const {  // not unit
    const double piece = std::floor(piece_at(distance));
    return curve_(piece + 1) - curve_(piece);
  }

 private:
  [[nodiscard]] dvec3 begin(std::size_t piece) const { return curve_(static_cast<double>(piece)); }

  [[nodiscard]] double piece_at(double distance) const {
    const auto after = std::upper_bound(distances_.begin() + 1, distances_.end() - 1, distance);
    const auto piece = static_cast<std::size_t>(after - distances_.begin()) - 1;
    return static_cast<double>(piece) + (distance - distances_[piece]) / (distances_[piece + 1] - distances_[piece]);
  }

  Curve curve_;
  std::vector<double> distances_{0};  // at each piece's beginning, and the whole length
};

Way walk_of(const Scene& scene, const SynthOptions& options) {
  check(options);
  if (scene.walk.size() < 4) {
    throw std::invalid_argument("scene: walk has " + std::to_string(scene.walk.size()) +
                                " points, must have at least 4");
  }
  constexpr double kFine = 256;  // pieces per segment: chords within 1e-5 of the arc
  const Spline curve(scene.walk, Spline::Ends::closed);
  return {[curve](double piece) { return curve.at(piece / kFine); }, static_cast<std::size_t>(kFine * curve.length())};
}

// The camera at a distance along the way, turned as the gaze says, less or more by `aside` of heading.
Camera camera_at(const Way& way, double distance, const Gaze& gaze, Camera camera, double aside = 0) {
  const double share = distance / way.length();
  double heading = gaze.start;
  if (gaze.heading == Gaze::Heading::turning) heading += kTurn * gaze.turns * share;
  if (gaze.heading == Gaze::Heading::ahead) {
    const dvec3 ahead = way.direction(distance);
    heading = std::atan2(ahead.y, ahead.x);
  }
  heading += aside + gaze.swing * std::sin(kTurn * gaze.swings * share);
  look(camera, way.at(distance), heading, gaze.level + gaze.nod * std::sin(kTurn * gaze.nods * share));
  return camera;
}

// Returns whether cameras can pass: places that are clear of solids, with nothing between them.
Way::Passable clear_in(const Scene& scene, const Tracer& tracer) {
  return [&](const dvec3& from, const dvec3& to) {
    return is_free(scene, tracer, from, scene.clearance) && is_free(scene, tracer, to, scene.clearance) &&
           tracer.sees(from, to);
  };
}

// The middle of each of options.views equal parts of the way.
std::vector<double> middles(const Way& way, const SynthOptions& options, const char* name) {
  if (!(way.length() > 0)) {
    throw std::invalid_argument("scene: no part of the trajectory " + std::string(name) + " is in the open");
  }
  std::vector<double> distances;
  for (std::uint32_t view = 0; view < options.views; ++view) {
    distances.push_back(way.length() * (view + 0.5) / options.views);
  }
  return distances;
}

// Returns the order of a curve of 4^order cells, each of which gets three views or more if there are enough views.
std::uint32_t hilbert_order(std::uint32_t views) {
  std::uint32_t order = 1;
  while (order < kMostHilbertOrder && 3ULL << (2 * (order + 1)) <= views) ++order;
  return order;
}

std::vector<Camera> cameras_on_hilbert(const Scene& scene, const Tracer& tracer, const SynthOptions& options) {
  constexpr double kFine = 8;  // pieces per segment, which are as long as a cell
  const std::uint32_t order = hilbert_order(options.views);
  const double side = 1U << order;
  std::vector<dvec3> points;
  for (const glm::ivec2& cell : hilbert_cells(order)) {
    const dvec2 at = (dvec2(cell) + 0.5) / side;
    points.push_back(scene.flight.corner + at.x * scene.flight.along + at.y * scene.flight.aside);
  }
  const Spline curve(points, Spline::Ends::open);
  const Way way([&](double piece) { return curve.at(piece / kFine); }, static_cast<std::size_t>(kFine * curve.length()),
                clear_in(scene, tracer));
  std::vector<Camera> cameras;
  for (const double distance : middles(way, options, "hilbert")) {
    cameras.push_back(camera_at(way, distance, scene.flight.gaze, camera_without_pose(options)));
  }
  return cameras;
}

std::vector<Camera> cameras_on_orbit(const Scene& scene, const Tracer& tracer, const SynthOptions& options) {
  constexpr std::size_t kPieces = 1024;
  const Orbit& orbit = scene.orbit;
  const Way way(
      [&](double piece) {
        const double angle = kTurn * piece / kPieces;
        const dvec2 at = dvec2(orbit.middle) + orbit.radii * dvec2(std::cos(angle), std::sin(angle));
        return dvec3(at, orbit.height);
      },
      kPieces, clear_in(scene, tracer));
  std::vector<Camera> cameras;
  for (const double distance : middles(way, options, "orbit")) {
    const dvec3 center = way.at(distance);
    const dvec3 towards = orbit.middle - center;
    Camera& camera = cameras.emplace_back(camera_without_pose(options));
    look(camera, center, std::atan2(towards.y, towards.x), std::asin(towards.z / glm::length(towards)));
  }
  return cameras;
}

// ---- Random poses.

// Returns whether most of the picture is surface that is not too near to be looked at.
bool sees_surface(const Tracer& tracer, const Camera& camera, double nearest) {
  constexpr int kGrid = 12;
  constexpr double kLeast = 0.7;  // share of the picture
  int seen = 0;
  for (int y = 0; y < kGrid; ++y) {
    for (int x = 0; x < kGrid; ++x) {
      const dvec2 at((x + 0.5) * camera.width / kGrid, (y + 0.5) * camera.height / kGrid);
      const std::optional<dvec3> point = tracer.surface_at(camera, at);
      if (point && glm::distance(*point, camera.center()) > nearest) ++seen;
    }
  }
  return seen >= kLeast * kGrid * kGrid;
}

Camera random_camera(const Scene& scene, const Tracer& tracer, Camera camera, Random random) {
  constexpr int kAttempts = 10000;
  const Stay& stay = scene.stay;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    dvec3 place;
    for (int axis = 0; axis < 3; ++axis) place[axis] = random.uniform(stay.low[axis], stay.high[axis]);
    const double heading = random.uniform(0, kTurn);
    look(camera, place, heading, random.uniform(stay.lowest_pitch, stay.highest_pitch));
    if (is_free(scene, tracer, place, scene.clearance) && sees_surface(tracer, camera, 2 * scene.clearance)) {
      return camera;
    }
  }
  throw std::invalid_argument("scene: no random pose sees surface, in " + std::to_string(kAttempts) + " attempts");
}

enum PoseUse : std::uint64_t { kViews = 0x72616e64, kTests };  // uses of random numbers

std::vector<Camera> random_cameras(const Scene& scene, const Tracer& tracer, const SynthOptions& options,
                                   std::uint32_t count, PoseUse use) {
  std::vector<Camera> cameras(count);
  tbb::parallel_for(std::uint32_t{0}, count, [&](std::uint32_t i) {
    cameras[i] =
        random_camera(scene, tracer, camera_without_pose(options), Random(hashed(options.seed, use, std::uint64_t{i})));
  });
  return cameras;
}

}  // namespace

std::vector<Camera> cameras_on_walk(const Scene& scene, const SynthOptions& options) {
  const Way walk = walk_of(scene, options);
  std::vector<Camera> cameras;
  for (std::uint32_t view = 0; view < options.views; ++view) {
    const double distance = walk.length() * (static_cast<double>(view) / options.views);
    cameras.push_back(camera_at(walk, distance, scene.walk_gaze, camera_without_pose(options)));
  }
  return cameras;
}

std::vector<Camera> cameras_on_path(const Scene& scene, const SynthOptions& options) {
  constexpr double kAbove = 0.12;  // scene units: free of the furniture, for the walk is above all that it passes
  constexpr double kAside = 0.35;  // radians, of the heading
  const Way walk = walk_of(scene, options);
  Gaze gaze = scene.walk_gaze;
  gaze.nod = -gaze.nod;
  std::vector<Camera> cameras;
  for (std::uint32_t frame = 0; frame < options.path_frames; ++frame) {
    const double distance = std::fmod(options.path_step * frame, walk.length());
    Camera& camera = cameras.emplace_back(camera_at(walk, distance, gaze, camera_without_pose(options), kAside));
    const dvec3 raised = camera.center() + dvec3(0, 0, kAbove);
    camera.cam_from_world_translation = -(camera.cam_from_world_rotation * raised);
  }
  return cameras;
}

std::vector<Camera> cameras_on_trajectory(const Scene& scene, const Tracer& tracer, const SynthOptions& options) {
  check(options);
  switch (synth_trajectory(options).trajectory) {
    case SynthTrajectory::hilbert:
      return cameras_on_hilbert(scene, tracer, options);
    case SynthTrajectory::orbit:
      return cameras_on_orbit(scene, tracer, options);
    case SynthTrajectory::random:
      return random_cameras(scene, tracer, options, options.views, kViews);
    case SynthTrajectory::walk:
      break;
  }
  return cameras_on_walk(scene, options);
}

std::vector<Camera> test_cameras(const Scene& scene, const Tracer& tracer, const SynthOptions& options) {
  check(options);
  return random_cameras(scene, tracer, options, options.test_views, kTests);
}

}  // namespace lumatlas::synth
