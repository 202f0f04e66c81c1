// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/visibility_agreement.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

namespace lumatlas {

namespace {

bool is_away_from_silhouettes(const VisibilityBuffer& buffer, std::size_t x, std::size_t y) {
  float nearest = std::numeric_limits<float>::infinity();
  float farthest = 0;
  for (std::size_t row = y - std::min<std::size_t>(y, 1); row <= y + 1 && row < buffer.height; ++row) {
    for (std::size_t column = x - std::min<std::size_t>(x, 1); column <= x + 1 && column < buffer.width; ++column) {
      const float depth = buffer.depth[row * buffer.width + column];
      nearest = std::min(nearest, depth);
      farthest = std::max(farthest, depth);
    }
  }
  return std::isinf(nearest) || farthest <= 1.05f * nearest;
}

double relative_difference(double a, double b) {
  return std::abs(a - b) / std::min(a, b);
}

}  // namespace

void compare(const VisibilityBuffer& expected, const VisibilityBuffer& actual, VisibilityAgreement& agreement) {
  REQUIRE(actual.width == expected.width);
  REQUIRE(actual.height == expected.height);
  REQUIRE(actual.face.size() == expected.face.size());
  REQUIRE(actual.depth.size() == expected.depth.size());
  agreement.pixels += expected.face.size();
  for (std::size_t pixel = 0; pixel < expected.face.size(); ++pixel) {
    if (!is_away_from_silhouettes(expected, pixel % expected.width, pixel / expected.width)) continue;
    ++agreement.smooth;
    agreement.other_face += expected.face[pixel] != actual.face[pixel];
    const bool hit = expected.face[pixel] != FaceId::none;
    if (hit != (actual.face[pixel] != FaceId::none)) {
      ++agreement.differ;
    } else if (hit) {
      const double difference = relative_difference(expected.depth[pixel], actual.depth[pixel]);
      const bool same_face = expected.face[pixel] == actual.face[pixel];
      if (same_face) agreement.worst_depth = std::max(agreement.worst_depth, difference);
      agreement.differ += !same_face && !(difference <= 1e-4);
    }
  }
}

}  // namespace lumatlas
