// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/geometric_weight.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace lumatlas {

double geometric_weight(const glm::dvec3& world, const glm::dvec3& novel_center, const glm::dvec3& stored_center,
                        const BlendOptions& options) {
  const double o = glm::length(novel_center - world);
  const double i = glm::length(stored_center - world);
  if (!(o > 0 && i > 0)) return 0;
  const double w_dir = std::max(0.0, glm::dot(novel_center - world, stored_center - world) / (o * i));
  const double w_pos =
      options.position == BlendOptions::Position::printed ? std::max(0.0, 1 - o / i) : std::min(o, i) / std::max(o, i);
  return options.lambda * w_dir + (1 - options.lambda) * w_pos;
}

double rim_share(const glm::dvec3& world, const glm::dvec3& novel_center, const glm::dvec3& stored_center,
                 const BlendOptions& options) {
  if (!options.rims) return 0;
  const double o = glm::length(novel_center - world);
  const double i = glm::length(stored_center - world);
  if (!(o > 0 && i > 0)) return 0;
  const double cosine = glm::dot(novel_center - world, stored_center - world) / (o * i);
  return glm::smoothstep(std::cos(glm::radians(kRimFarDegrees)), std::cos(glm::radians(kRimNearDegrees)), cosine);
}

double frame_share(const glm::dvec2& image, const glm::dvec2& size, double fade) {
  if (!(fade > 0)) return 1;
  const double band = fade * std::min(size.x, size.y);
  const glm::dvec2 share = glm::smoothstep(glm::dvec2(0), glm::dvec2(band), glm::min(image, size - image));
  return share.x * share.y;
}

double faded_weight(double weight, double left) {
  if (!(left < 1)) return weight;
  if (!(left > 0)) return 0;
  const double penalty = (1 - weight + kFadePenalty * (1 - left)) / left;
  return std::max(1 - penalty, kLeastFaded * left * weight);
}

}  // namespace lumatlas
