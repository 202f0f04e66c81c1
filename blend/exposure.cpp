// SPDX-License-Identifier: GPL-3.0-or-later
// Source: D. Shepard, "A two-dimensional interpolation function for irregularly-spaced data", 1968.
#include "blend/exposure.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <utility>

#include "mesh/base/median.h"

namespace lumatlas {

namespace {

// e: a tenth of D apart counts as the same place. Far less would make every stored view a spike that a camera passing
// it flickers through, and would believe the gain of a single view.
constexpr double kSamePlace = 0.01;

// Enough for a median; odd strides below, so that they do not fall on the same columns of every row.
constexpr std::size_t kDepthSamples = 1024;

std::vector<double> sparse_depths(const StoredView& view, float below) {
  const std::size_t stride = (view.mask->depth.size() / kDepthSamples) | 1;
  std::vector<double> depths;
  for (std::size_t pixel = 0; pixel < view.mask->depth.size(); pixel += stride) {
    if (view.mask->depth[pixel] < below) depths.push_back(view.mask->depth[pixel]);
  }
  return depths;
}

}  // namespace

void NearbyExposure::follow_depths(const Snapshot& snapshot) {
  const float below = snapshot.surface ? depth_before_far(*snapshot.surface) : std::numeric_limits<float>::infinity();
  if (std::exchange(below_, below) != below) medians_.clear();
  medians_.resize(snapshot.views.size());
  std::vector<double> medians;
  for (std::size_t slot = 0; slot < medians_.size(); ++slot) {
    if (!snapshot.views[slot]) continue;
    const std::shared_ptr<const ViewMask>& mask = snapshot.views[slot]->mask;
    Median& median = medians_[slot];
    if (median.mask.owner_before(mask) || mask.owner_before(median.mask)) {
      std::vector<double> depths = sparse_depths(*snapshot.views[slot], below);
      median = {mask, depths.empty() ? std::nullopt : std::optional(upper_median(depths))};
    }
    if (median.depth) medians.push_back(*median.depth);
  }
  per_depth_ = medians.empty() ? 0 : 1 / upper_median(medians);
}

void NearbyExposure::follow(const Snapshot& snapshot) {
  check_gains(snapshot);
  follow_depths(snapshot);
  views_.clear();
  for (std::size_t slot = 0; slot < snapshot.views.size(); ++slot) {
    if (!snapshot.views[slot]) continue;
    const Camera& camera = snapshot.views[slot]->camera;
    views_.push_back({camera.center(), camera.viewing_direction(), glm::log(snapshot.gains[slot])});
  }
}

glm::dvec3 NearbyExposure::at(const Camera& camera) const {
  const glm::dvec3 center = camera.center();
  const glm::dvec3 direction = camera.viewing_direction();
  double total = 0;
  glm::dvec3 sum(0);
  for (const View& view : views_) {
    const glm::dvec3 apart = (center - view.center) * per_depth_;  // in units of D
    const glm::dvec3 looks_apart = apart + direction - view.direction;
    const double q = glm::dot(apart, apart) + glm::dot(looks_apart, looks_apart);
    const double w = 1 / ((q + kSamePlace) * (q + kSamePlace));
    total += w;
    sum += w * view.log_gain;
  }
  // From so far away that no weight is left, no view is nearer than another.
  return total > 0 ? glm::exp(-sum / total) : glm::dvec3(1);
}

glm::dvec3 shown_gain(const glm::dvec3& gain, const glm::dvec3& color, const glm::dvec3& exposure) {
  const glm::dvec3 clipped = glm::smoothstep(glm::dvec3(kClippedFrom), glm::dvec3(1), color);
  return glm::mix(gain, glm::max(gain, 1.0 / exposure), clipped);
}

glm::dvec3 picture_exposure(const NearbyExposure& nearby, const Camera& camera, const BlendOptions& options) {
  return options.exposure == BlendOptions::Exposure::nearby ? nearby.at(camera) : glm::dvec3(1);
}

}  // namespace lumatlas
