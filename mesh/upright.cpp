// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/upright.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <glm/glm.hpp>
#include <stdexcept>

namespace lumatlas {

namespace {

using glm::dmat3;
using glm::dvec3;

dvec3 row(const Camera& camera, int index) {
  return glm::transpose(camera.cam_from_world_rotation)[index];
}

// The eigenvector of a symmetric matrix's least eigenvalue.
dvec3 least_axis(const dmat3& matrix) {
  Eigen::Matrix3d same;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) same(i, j) = matrix[i][j];
  }
  const Eigen::Vector3d least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(same).eigenvectors().col(0);
  return {least.x(), least.y(), least.z()};
}

}  // namespace

dvec3 upward(std::span<const Camera> cameras) {
  if (cameras.empty()) throw std::invalid_argument("upward: there is no camera, must be at least one");
  constexpr double kPull = 1e-3;  // weight of the pictures' own up, where the x axes leave it open
  dvec3 mean(0);
  for (const Camera& camera : cameras) mean -= row(camera, 1);
  if (!(glm::length(mean) > 1e-6 * static_cast<double>(cameras.size()))) mean = -row(cameras.front(), 1);
  mean = glm::normalize(mean);
  dmat3 spread = kPull * (dmat3(1) - glm::outerProduct(mean, mean));
  for (const Camera& camera : cameras) {
    spread += glm::outerProduct(row(camera, 0), row(camera, 0)) / static_cast<double>(cameras.size());
  }
  const dvec3 up = least_axis(spread);
  return glm::dot(up, mean) < 0 ? -up : up;
}

dmat3 upright(std::span<const Camera> cameras, const dvec3& up) {
  dvec3 ahead(0);
  for (const Camera& camera : cameras) ahead += camera.viewing_direction();
  ahead -= glm::dot(ahead, up) * up;
  if (!(glm::length(ahead) > 1e-3 * static_cast<double>(cameras.size()))) {
    const dvec3 axis = std::abs(up.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
    ahead = glm::cross(axis, up);  // they look all around
  }
  const dvec3 y = glm::normalize(up), z = -glm::normalize(ahead), x = glm::cross(y, z);
  return glm::transpose(dmat3(x, y, z));
}

}  // namespace lumatlas
