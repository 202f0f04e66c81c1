// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: K. Shoemake, "Animating rotation with quaternion curves", 1985: Bezier curves on the sphere of quaternions
// by de Casteljau's construction. The speeds at key frames are Bessel's tangents.
#include "tools/picture/paths/camera_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <stdexcept>
#include <string>

#include "mesh/finite.h"

namespace lumatlas {

namespace {

using glm::dquat;
using glm::dvec3;

// The control points of a turn are no further than this from its ends, radians: with the half circle between the ends
// less than a full one, beyond which a turn is not what its control points say. Only where a short interval with a
// large turn follows a long one is there more to want.
constexpr double kMostControlTurn = 1.5;

dvec3 at_most(const dvec3& v, double most) {
  const double length = glm::length(v);
  return length > most ? v * (most / length) : v;
}

double log_focal(double fov_deg) {
  return -std::log(std::tan(glm::radians(fov_deg) / 2));
}

double fov_deg_of(double log_focal) {
  return 2 * glm::degrees(std::atan(std::exp(-log_focal)));
}

// The rotation vector, radians; of a quaternion with w < 0 the turn is more than half a circle.
dvec3 log_of(const dquat& q) {
  const dvec3 axis(q.x, q.y, q.z);
  const double sine = glm::length(axis);
  return sine > 1e-12 ? axis * (2 * std::atan2(sine, q.w) / sine) : 2.0 * axis;
}

dquat exp_of(const dvec3& turn) {
  const double half = glm::length(turn) / 2;
  const double factor = half > 1e-9 ? std::sin(half) / (2 * half) : 0.5;
  return glm::normalize(dquat(std::cos(half), turn * factor));
}

// A turn has two quaternions; this is the one of them that is nearer to another.
dquat nearer(const dquat& q, const dquat& to) {
  return glm::dot(q, to) < 0 ? -q : q;
}

// The shortest turn from one to the other, in the camera's frame: to = exp_of(turn) * from.
dvec3 turn_between(const dquat& from, const dquat& to) {
  return log_of(nearer(to, from) * glm::conjugate(from));
}

// On the great circle of the quaternions themselves, not of the nearer ones: those could change on the way.
dquat part_of_turn(const dquat& from, const dquat& to, double part) {
  return glm::normalize(exp_of(part * log_of(to * glm::conjugate(from))) * from);
}

dquat bezier(std::array<dquat, 4> control, double part) {
  for (std::size_t left = control.size() - 1; left > 0; --left) {
    for (std::size_t i = 0; i < left; ++i) control[i] = part_of_turn(control[i], control[i + 1], part);
  }
  return control[0];
}

// The cubic with these values and, per unit of `part`, these speeds at its ends.
template <typename T>
T cubic(const T& from, const T& from_speed, const T& to, const T& to_speed, double part) {
  const double rest = 1 - part;
  return from * (rest * rest * (1 + 2 * part)) + from_speed * (rest * rest * part) +
         to * (part * part * (1 + 2 * rest)) - to_speed * (part * part * rest);
}

[[noreturn]] void refuse(std::size_t key, const std::string& why) {
  throw std::invalid_argument("path: key frame " + std::to_string(key) + " " + why);
}

void check(const std::vector<KeyFrame>& keys) {
  if (keys.empty()) throw std::invalid_argument("path: it has no key frames, must have at least one");
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Vantage& vantage = keys[i].vantage;
    if (!std::isfinite(keys[i].time)) refuse(i, "has a time that is not finite");
    if (i > 0 && !(keys[i].time > keys[i - 1].time)) {
      refuse(i, "is at time " + std::to_string(keys[i].time) + ", must be later than the one before it, at " +
                    std::to_string(keys[i - 1].time));
    }
    if (!is_finite(vantage.position)) refuse(i, "has a position that is not finite");
    if (!(std::abs(glm::length(vantage.cam_from_world) - 1) < 1e-6)) refuse(i, "has a turn that is no unit quaternion");
    if (!(vantage.fov_deg > 0 && vantage.fov_deg < 180)) {
      refuse(i, "has a field of view of " + std::to_string(vantage.fov_deg) + " degrees, must be in (0, 180)");
    }
  }
}

}  // namespace

dquat look_at(const dvec3& position, const dvec3& target, const dvec3& up) {
  const double distance = glm::length(target - position);
  if (!(distance > 0)) throw std::invalid_argument("camera: it looks at the point where it stands");
  const dvec3 forward = (target - position) / distance;
  dvec3 right = glm::cross(forward, up);
  if (!(glm::length(right) > 1e-9 * glm::length(up))) {
    right = glm::cross(forward, std::abs(forward.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0));
  }
  right = glm::normalize(right);
  return glm::normalize(glm::quat_cast(glm::transpose(glm::dmat3(right, glm::cross(forward, right), forward))));
}

Camera camera_at(const Vantage& vantage, std::uint32_t width, std::uint32_t height) {
  if (!(vantage.fov_deg > 0 && vantage.fov_deg < 180)) {
    throw std::invalid_argument("camera: field of view is " + std::to_string(vantage.fov_deg) +
                                " degrees, must be in (0, 180)");
  }
  Camera camera = centered_camera(width, height, width / 2.0 * std::exp(log_focal(vantage.fov_deg)));
  camera.cam_from_world_rotation = glm::mat3_cast(glm::normalize(vantage.cam_from_world));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * vantage.position);
  check(camera);
  return camera;
}

CameraPath::CameraPath(std::vector<KeyFrame> keys) : keys_(std::move(keys)), speeds_(keys_.size()) {
  check(keys_);
  if (keys_.size() < 2) return;
  speeds_.front() = between(0);
  speeds_.back() = between(keys_.size() - 2);
  for (std::size_t i = 1; i + 1 < keys_.size(); ++i) {
    const double before = keys_[i].time - keys_[i - 1].time;
    const double after = keys_[i + 1].time - keys_[i].time;
    const double weight = before / (before + after);  // weight of the later interval: the shorter one knows better
    const Speed a = between(i - 1);
    const Speed b = between(i);
    speeds_[i] = {glm::mix(a.position, b.position, weight),
                  at_most(glm::mix(a.turn, b.turn, weight), 3 * kMostControlTurn / std::max(before, after)),
                  glm::mix(a.log_focal, b.log_focal, weight)};
  }
}

CameraPath::Speed CameraPath::between(std::size_t first) const {
  const KeyFrame& a = keys_[first];
  const KeyFrame& b = keys_[first + 1];
  const double time = b.time - a.time;
  return {(b.vantage.position - a.vantage.position) / time,
          turn_between(a.vantage.cam_from_world, b.vantage.cam_from_world) / time,
          (log_focal(b.vantage.fov_deg) - log_focal(a.vantage.fov_deg)) / time};
}

Vantage CameraPath::at(double time) const {
  if (!(time > begin())) return keys_.front().vantage;
  if (time >= end()) return keys_.back().vantage;
  const auto after = std::upper_bound(keys_.begin(), keys_.end(), time,
                                      [](double value, const KeyFrame& key) { return value < key.time; });
  const auto i = static_cast<std::size_t>(after - keys_.begin()) - 1;
  const KeyFrame& a = keys_[i];
  const KeyFrame& b = keys_[i + 1];
  const double length = b.time - a.time;
  const double part = (time - a.time) / length;
  const dquat& from = a.vantage.cam_from_world;
  const dquat to = nearer(b.vantage.cam_from_world, from);
  return {cubic(a.vantage.position, speeds_[i].position * length, b.vantage.position, speeds_[i + 1].position * length,
                part),
          bezier({from, exp_of(speeds_[i].turn * (length / 3)) * from, exp_of(speeds_[i + 1].turn * (-length / 3)) * to,
                  to},
                 part),
          fov_deg_of(cubic(log_focal(a.vantage.fov_deg), speeds_[i].log_focal * length, log_focal(b.vantage.fov_deg),
                           speeds_[i + 1].log_focal * length, part))};
}

std::vector<Vantage> CameraPath::evenly(std::size_t count) const {
  std::vector<Vantage> vantages;
  for (std::size_t i = 0; i < count; ++i) {
    const double part = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0;
    vantages.push_back(at(begin() + part * (end() - begin())));
  }
  return vantages;
}

}  // namespace lumatlas
