// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/errors/motion.h"

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace lumatlas::synth {
namespace {

glm::dmat3 turn(const glm::dvec3& rotation) {
  const double angle = glm::length(rotation);
  return angle > 0 ? glm::mat3_cast(glm::angleAxis(angle, rotation / angle)) : glm::dmat3(1.0);
}

}  // namespace

Motion operator*(double scale, const Motion& motion) {
  return {scale * motion.rotation, scale * motion.translation};
}

Camera moved(const Camera& camera, const Motion& motion) {
  Camera result = camera;
  const glm::dmat3 rotation = turn(motion.rotation);
  result.cam_from_world_rotation = rotation * camera.cam_from_world_rotation;
  result.cam_from_world_translation = rotation * camera.cam_from_world_translation + motion.translation;
  return result;
}

}  // namespace lumatlas::synth
