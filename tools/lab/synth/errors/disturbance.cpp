// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/errors/disturbance.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include "tools/lab/synth/random.h"

namespace lumatlas::synth {
namespace {

using glm::dvec3;

// Uses of random numbers; 1 and 2 are taken by the sparse points and the grain of the photographs.
enum PhotographUse : std::uint64_t {
  kPoseNoise = 3,
  kExposure,
  kWhiteBalance,
  kWhichAreWrong,
  kWrongPose,
  kWhichHavePassersBy,
  kPasserBy,
  kBlur
};

dvec3 random_direction(Random& random) {
  const double z = random.uniform(-1, 1);
  const double angle = random.uniform(0, 2 * std::numbers::pi);
  const double radius = std::sqrt(1 - z * z);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

// ---- Poses.

// The motion, longer or shorter, that displaces the points by `target` pixels, as `displacement` measures it. That
// grows continuously from 0 beyond all bounds or, where the points stay in front, to the spread of the picture, which
// is more than any `target` that the options allow.
template <typename Displacement>
Motion scaled_to(double target, const Motion& motion, const Displacement& displacement_of) {
  const auto displacement = [&](double scale) { return displacement_of(scale * motion); };
  double low = 0;
  double high = 1e-6;
  while (displacement(high) < target) high *= 2;
  for (int halving = 0; halving < 100; ++halving) {
    const double middle = 0.5 * (low + high);
    (displacement(middle) < target ? low : high) = middle;
  }
  return low * motion;
}

// Rotation and translation each displace the surface by the same number of pixels, both together by `target`.
template <typename Displacement>
Motion random_motion(double target, const Displacement& displacement, Random random) {
  const Motion rotation{random_direction(random), dvec3(0.0)};
  const Motion translation{dvec3(0.0), random_direction(random)};
  const Motion both{scaled_to(0.5 * target, rotation, displacement).rotation,
                    scaled_to(0.5 * target, translation, displacement).translation};
  return scaled_to(target, both, displacement);
}

double diameter(const Mesh& mesh) {
  glm::vec3 low(std::numeric_limits<float>::infinity());
  glm::vec3 high(-std::numeric_limits<float>::infinity());
  for (const glm::vec3& position : mesh.positions) {
    low = glm::min(low, position);
    high = glm::max(high, position);
  }
  return glm::distance(low, high);
}

// Turned by 10 to 30 degrees and moved by 5 to 15% of the scene's diameter to where a camera could be; only turned if
// no such place is found.
Camera with_wrong_pose(const Scene& scene, const Tracer& tracer, const Camera& camera, Random random) {
  constexpr int kAttempts = 100;
  constexpr double kClearance = 0.2;  // scene units, about that of the walk
  const double angle = glm::radians(random.uniform(10, 30));
  const dvec3 axis = random_direction(random);
  dvec3 center = camera.center();
  const double size = diameter(scene.geometry.mesh);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const double distance = size * random.uniform(0.05, 0.15);
    const dvec3 place = camera.center() + distance * random_direction(random);
    if (!is_free(scene, tracer, place, kClearance)) continue;
    center = place;
    break;
  }
  Camera wrong = moved(camera, {angle * axis, dvec3(0.0)});
  wrong.cam_from_world_translation = -(wrong.cam_from_world_rotation * center);
  return wrong;
}

// ---- The shutter.

void shake(const Tracer& tracer, const Camera& camera, const SynthOptions& options, std::uint64_t view,
           Disturbance& disturbance) {
  if (options.disturbances.blur == 0) return;
  const std::vector<dvec3> points = points_in_view(tracer, camera);
  if (points.empty()) return;
  const auto displacement = [&](const Motion& motion) {
    return displacement_px(moved(camera, -0.5 * motion), moved(camera, 0.5 * motion), points);
  };
  const Random random(hashed(options.seed, kBlur, view));
  disturbance.exposure.motion = random_motion(options.disturbances.blur, displacement, random);
  disturbance.blur_px = displacement(disturbance.exposure.motion);
}

// ---- Exposures.

Exposure exposure_of(const SynthOptions& options, std::uint64_t view) {
  const SynthDisturbances& asked = options.disturbances;
  const auto factor = [](double ev, Random& random) { return std::exp2(random.uniform(-ev, ev)); };
  Random brightness(hashed(options.seed, kExposure, view));
  Random balance(hashed(options.seed, kWhiteBalance, view));
  const double all = factor(asked.exposure_noise, brightness);
  const double red = factor(asked.white_balance_noise, balance);
  const double blue = factor(asked.white_balance_noise, balance);
  Exposure exposure;
  exposure.gain = dvec3(all * red, all, all * blue);
  exposure.vignetting = asked.vignetting;
  exposure.noise = asked.noise;
  return exposure;
}

// ---- Which views.

std::size_t rounded(double share, std::size_t count) {
  return static_cast<std::size_t>(std::llround(share * static_cast<double>(count)));
}

std::vector<std::size_t> shuffled(std::size_t count, Random random) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = count; i > 1; --i) {
    std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
  }
  return order;
}

void choose_wrong_poses(const SynthOptions& options, std::vector<Disturbance>& views) {
  const auto order = shuffled(views.size(), Random(hashed(options.seed, kWhichAreWrong)));
  const std::size_t count = rounded(options.disturbances.wrong_poses, views.size());
  for (std::size_t i = 0; i < count; ++i) views[order[i]].wrong = true;
}

// One view after the other: whether a view gets one depends on how many were found before.
void add_passers_by(const Scene& scene, const Tracer& tracer, std::span<const Camera> cameras,
                    const SynthOptions& options, std::vector<Disturbance>& views) {
  std::size_t left = rounded(options.disturbances.passers_by, views.size());
  if (left == 0) return;
  for (const std::size_t view : shuffled(views.size(), Random(hashed(options.seed, kWhichHavePassersBy)))) {
    views[view].passer_by = find_passer_by(scene, tracer, cameras[view], hashed(options.seed, kPasserBy, view));
    if (views[view].passer_by && --left == 0) return;
  }
}

void disturb_pose(const Scene& scene, const Tracer& tracer, const Camera& camera, const SynthOptions& options,
                  std::uint64_t view, Disturbance& disturbance) {
  const double noise = options.disturbances.pose_noise;
  if (!disturbance.wrong && noise == 0) return;
  const std::vector<dvec3> points = points_in_view(tracer, camera);
  if (disturbance.wrong) {
    disturbance.written = with_wrong_pose(scene, tracer, camera, Random(hashed(options.seed, kWrongPose, view)));
  } else if (!points.empty()) {
    const auto displacement = [&](const Motion& motion) {
      return displacement_px(camera, moved(camera, motion), points);
    };
    disturbance.written =
        moved(camera, random_motion(noise, displacement, Random(hashed(options.seed, kPoseNoise, view))));
  }
  disturbance.displacement_px = displacement_px(camera, disturbance.written, points);
}

}  // namespace

std::vector<Disturbance> disturb(const Scene& scene, const Tracer& tracer, std::span<const Camera> cameras,
                                 const SynthOptions& options) {
  check(options);
  std::vector<Disturbance> views(cameras.size());
  choose_wrong_poses(options, views);
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t view) {
    views[view].written = cameras[view];
    views[view].exposure = exposure_of(options, view);
    disturb_pose(scene, tracer, cameras[view], options, view, views[view]);
    shake(tracer, cameras[view], options, view, views[view]);
  });
  add_passers_by(scene, tracer, cameras, options, views);
  return views;
}

std::vector<dvec3> points_in_view(const Tracer& tracer, const Camera& camera) {
  constexpr std::uint32_t kMost = 32;
  const std::uint32_t columns = std::min(kMost, camera.width);
  const std::uint32_t rows = std::min(kMost, camera.height);
  std::vector<dvec3> points;
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) {
      const glm::dvec2 at((x + 0.5) * camera.width / columns, (y + 0.5) * camera.height / rows);
      if (const auto point = tracer.surface_at(camera, at)) points.push_back(*point);
    }
  }
  return points;
}

double displacement_px(const Camera& a, const Camera& b, std::span<const dvec3> points) {
  if (points.empty()) return 0;
  double sum = 0;
  for (const dvec3& point : points) {
    const dvec3 in_a = a.cam_from_world(point);
    const dvec3 in_b = b.cam_from_world(point);
    if (in_a.z <= 0 || in_b.z <= 0) return std::numeric_limits<double>::infinity();
    const glm::dvec2 shift = a.image_from_cam(in_a) - b.image_from_cam(in_b);
    sum += glm::dot(shift, shift);
  }
  return std::sqrt(sum / static_cast<double>(points.size()));
}

}  // namespace lumatlas::synth
