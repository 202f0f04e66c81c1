// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/measures/pose_error.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace lumatlas {

namespace {

using glm::dvec3;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::uint32_t kPointsAlongSide = 32;
constexpr int kIterations = 100;
constexpr double kSmallestStep_px = 1e-9;
// Distances below this count by their square, which keeps the weights finite and the convergence quadratic.
constexpr double kSharp_px = 0.1;

struct NormalEquations {
  Matrix6 matrix = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  double weight = 0;

  void add(const Vector6& derivative, double misfit, double row_weight) {
    matrix += row_weight * derivative * derivative.transpose();
    right -= row_weight * misfit * derivative;
  }
};

dvec3 moved(const RigidMotion& motion, const dvec3& point) {
  return motion.rotation * point + motion.translation;
}

// Returns the derivative by a turn about the world's origin and a shift after it, from the derivative by the point.
Vector6 by_motion(const dvec3& point, const dvec3& by_point) {
  const dvec3 by_turn = glm::cross(point, by_point);
  Vector6 result;
  result << by_turn.x, by_turn.y, by_turn.z, by_point.x, by_point.y, by_point.z;
  return result;
}

void add_point(const PosePair& pair, const RigidMotion& motion, const dvec3& point, NormalEquations& equations) {
  const dvec3 world = moved(motion, point);
  const dvec3 cam = pair.measured.cam_from_world(world);
  const dvec3 true_cam = pair.truth.cam_from_world(point);
  if (!(cam.z > 0) || !(true_cam.z > 0)) return;
  const glm::dvec2 misfit = pair.measured.image_from_cam(cam) - pair.truth.image_from_cam(true_cam);
  const double weight = 1 / std::max(glm::length(misfit), kSharp_px);
  const double x_slope = pair.measured.fx / cam.z;
  const double y_slope = pair.measured.fy / cam.z;
  const dvec3 x_by_cam(x_slope, 0, -x_slope * cam.x / cam.z);
  const dvec3 y_by_cam(0, y_slope, -y_slope * cam.y / cam.z);
  const glm::dmat3 world_from_cam = glm::transpose(pair.measured.cam_from_world_rotation);
  equations.add(by_motion(world, world_from_cam * x_by_cam), misfit.x, weight);
  equations.add(by_motion(world, world_from_cam * y_by_cam), misfit.y, weight);
  equations.weight += weight;
}

RigidMotion stepped(const RigidMotion& motion, const Vector6& step) {
  const dvec3 turn(step[0], step[1], step[2]);
  const double angle = glm::length(turn);
  const glm::dmat3 rotation = angle > 0 ? glm::mat3_cast(glm::angleAxis(angle, turn / angle)) : glm::dmat3(1.0);
  return {rotation * motion.rotation, rotation * motion.translation + dvec3(step[3], step[4], step[5])};
}

}  // namespace

std::vector<dvec3> points_seen(const Camera& camera, const Visibility& visibility) {
  const Camera small = camera.shrunk_to(kPointsAlongSide);
  const VisibilityBuffer seen = visibility.trace(small);
  std::vector<dvec3> points;
  for (std::uint32_t y = 0; y < seen.height; ++y) {
    for (std::uint32_t x = 0; x < seen.width; ++x) {
      const double depth = seen.depth[std::size_t{y} * seen.width + x];
      if (std::isfinite(depth)) points.push_back(small.center() + depth * small.ray({x + 0.5, y + 0.5}));
    }
  }
  return points;
}

Camera before_motion(const Camera& camera, const RigidMotion& motion) {
  Camera result = camera;
  result.cam_from_world_rotation = camera.cam_from_world_rotation * motion.rotation;
  result.cam_from_world_translation = camera.cam_from_world(motion.translation);
  return result;
}

RigidMotion common_motion(std::span<const PosePair> pairs) {
  RigidMotion motion;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    NormalEquations equations;
    for (const PosePair& pair : pairs) {
      for (const dvec3& point : pair.points) add_point(pair, motion, point, equations);
    }
    const Eigen::LDLT<Matrix6> factors(equations.matrix);
    if (!(factors.rcond() > 1e-12)) return motion;
    const Vector6 step = factors.solve(equations.right);
    motion = stepped(motion, step);
    const double moved_px = std::sqrt(step.dot(equations.matrix * step) / equations.weight);
    if (moved_px < kSmallestStep_px) break;
  }
  return motion;
}

}  // namespace lumatlas
