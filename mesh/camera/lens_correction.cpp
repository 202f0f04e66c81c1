// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/camera/lens_correction.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr Requirement lens_correction_requires{"lens correction"};

}  // namespace

void check(const LensCorrection& correction) {
  lens_correction_requires(std::isfinite(correction.focal) && correction.focal > 0, "focal", correction.focal,
                           "finite and positive");
  lens_correction_requires(std::isfinite(correction.principal.x), "principal.x", correction.principal.x, "finite");
  lens_correction_requires(std::isfinite(correction.principal.y), "principal.y", correction.principal.y, "finite");
  lens_correction_requires(std::isfinite(correction.k1), "k1", correction.k1, "finite");
  lens_correction_requires(std::isfinite(correction.k2), "k2", correction.k2, "finite");
  lens_correction_requires(std::isfinite(correction.p1), "p1", correction.p1, "finite");
  lens_correction_requires(std::isfinite(correction.p2), "p2", correction.p2, "finite");
}

glm::dvec2 uncorrected(const LensCorrection& correction, const Camera& camera, const glm::dvec2& image) {
  const double x = (image.x - camera.cx) / camera.fx;
  const double y = (image.y - camera.cy) / camera.fy;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (correction.k1 + r2 * correction.k2);
  const double bent_x = x * radial + 2 * correction.p1 * x * y + correction.p2 * (r2 + 2 * x * x);
  const double bent_y = y * radial + 2 * correction.p2 * x * y + correction.p1 * (r2 + 2 * y * y);
  return {camera.fx * correction.focal * bent_x + camera.cx + camera.width * correction.principal.x,
          camera.fy * correction.focal * bent_y + camera.cy + camera.width * correction.principal.y};
}

bool share_a_lens(const Camera& a, const Camera& b) {
  const double tolerance = 1e-9 * a.width;
  const auto same = [&](double x, double y) { return std::abs(x - y) <= tolerance; };
  return a.width == b.width && a.height == b.height && same(a.fx, b.fx) && same(a.fy, b.fy) && same(a.cx, b.cx) &&
         same(a.cy, b.cy);
}

double corner_move_px(const LensCorrection& correction, const Camera& camera) {
  double most = 0;
  for (const double x : {0.0, static_cast<double>(camera.width)}) {
    for (const double y : {0.0, static_cast<double>(camera.height)}) {
      most = std::max(most, glm::distance(uncorrected(correction, camera, {x, y}), glm::dvec2(x, y)));
    }
  }
  return most;
}

LensCorrection combined(const LensCorrection& first, const LensCorrection& second) {
  return {first.focal * second.focal, first.principal + second.principal,
          first.k1 + second.k1,       first.k2 + second.k2,
          first.p1 + second.p1,       first.p2 + second.p2};
}

}  // namespace lumatlas
