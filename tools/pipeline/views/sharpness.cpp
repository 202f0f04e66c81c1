// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/views/sharpness.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <utility>

#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "planner/refinement/pyramid.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kLongerSide = 640;  // pixels at which detail is looked for
constexpr std::size_t kNeighbours = 20;     // most photographs that one is compared with
constexpr std::size_t kOneIn = 20;          // of this many photographs one is near enough to compare with
constexpr double kSharpest = 0.8;           // share of them that are less sharp than what it is compared with
constexpr double kTurn = 4;                 // distances to the middle of all cameras that 1 - cos of a turn is worth
constexpr double kSharp = 0.92;             // share of that detail from which a photograph counts as sharp
constexpr double kSharpnessOfDetail = 3;    // power of the share of detail below that
constexpr double kLeastDetail = 1e-6;       // of brightness in [0, 1]; less is none

double brightness(const Pyramid& pyramid, std::uint32_t level, const glm::dvec2& image) {
  return std::sqrt(std::max(glm::dot(pyramid.color(level, image), glm::dvec3(0.25, 0.5, 0.25)), 0.0));
}

// Returns the root of the mean squared difference of a level from the next one.
double detail_of(const Pyramid& pyramid, std::uint32_t level) {
  const PhotographSpan& span = pyramid.level(level);
  const double scale = std::ldexp(1.0, static_cast<int>(level));
  double sum = 0;
  std::size_t count = 0;
  for (std::uint32_t y = 0; y < span.height; ++y) {
    for (std::uint32_t x = 0; x < span.width; ++x) {
      const glm::dvec2 image = scale * (glm::dvec2(x, y) + 0.5);
      if (!pyramid.is_valid(image)) continue;
      const double difference = brightness(pyramid, level, image) - brightness(pyramid, level + 1, image);
      sum += difference * difference;
      ++count;
    }
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
}

constexpr Requirement sharpness_requires{"sharpness"};

}  // namespace

std::optional<double> fine_detail(const Photograph& photograph) {
  const Pyramid pyramid(PhotographSpan(photograph), 1);
  const std::uint32_t finest = pyramid.level_near(kLongerSide);
  if (finest + 2 >= pyramid.levels()) return std::nullopt;
  const double fine = detail_of(pyramid, finest), coarse = detail_of(pyramid, finest + 1);
  if (!(fine > kLeastDetail && coarse > kLeastDetail)) return std::nullopt;
  return std::log(fine / coarse);
}

std::vector<double> relative_sharpness(std::span<const Camera> cameras,
                                       std::span<const std::optional<double>> fine_detail) {
  sharpness_requires.has_size(fine_detail.size(), cameras.size(), "fine_detail", "the number of cameras");
  const std::size_t count = cameras.size();
  std::vector<double> sharpness(count, 1);
  if (count < 2) return sharpness;
  std::vector<glm::dvec3> centers(count), directions(count);
  glm::dvec3 middle(0);
  for (std::size_t i = 0; i < count; ++i) {
    centers[i] = cameras[i].center();
    directions[i] = glm::normalize(cameras[i].ray({cameras[i].cx, cameras[i].cy}));
    middle += centers[i] / static_cast<double>(count);
  }
  std::vector<double> distances(count);
  for (std::size_t i = 0; i < count; ++i) distances[i] = glm::distance(centers[i], middle);
  const double usual = upper_median(distances);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    if (!fine_detail[i]) return;
    std::vector<std::pair<double, std::size_t>> others;
    others.reserve(count - 1);
    for (std::size_t j = 0; j < count; ++j) {
      if (j == i || !fine_detail[j]) continue;
      const double turn = 1 - glm::dot(directions[i], directions[j]);
      others.emplace_back(glm::distance(centers[i], centers[j]) + kTurn * usual * turn, j);
    }
    const std::size_t nearest = std::min({kNeighbours, count / kOneIn, others.size()});
    std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(nearest), others.end());
    std::vector<double> details{*fine_detail[i]};
    for (std::size_t k = 0; k < nearest; ++k) details.push_back(*fine_detail[others[k].second]);
    const double sharp = percentile(details, kSharpest);
    sharpness[i] = std::exp(kSharpnessOfDetail * std::min(*fine_detail[i] - sharp - std::log(kSharp), 0.0));
  });
  return sharpness;
}

}  // namespace lumatlas
