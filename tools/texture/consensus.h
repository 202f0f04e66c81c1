// SPDX-License-Identifier: GPL-3.0-or-later
// The colours on which the views of a surface point agree: m, t and r_i of the formula in surface_color.h, from sums to
// which views are added one after the other.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "tools/texture/surface_place.h"

namespace lumatlas {

struct Consensus {
  glm::vec3 root{0.0f};   // mean of the square roots of s_i
  glm::vec3 broad{0.0f};  // mean of s_i, linear light
  float tolerance2 = 0;   // t^2
  float weight = 0;       // 0: no view shows the place, everything agrees with that

  // r_i of a view, by the square root of its s_i. (0, 1]
  [[nodiscard]] float agreement(const glm::vec3& other_root) const {
    if (!(weight > 0)) return 1;
    const glm::vec3 off = other_root - root;
    const float r = 1 / (1 + glm::dot(off, off) / tolerance2);
    return r * r;
  }
};

class ConsensusSums {
 public:
  // Adds the view with the weight of its agreement with an earlier consensus.
  void add(const ShownPlace& shown, const Consensus& earlier) {
    const float share = shown.base * earlier.agreement(shown.root);
    roots_ += share * shown.root;
    broad_ += share * shown.smooth;
    squares_ += share * glm::dot(shown.root, shown.root);
    weight_ += share;
  }

  [[nodiscard]] Consensus result(float tolerance) const {
    constexpr float kSpreads = 2;  // a view this many times the spread away from the mean has a quarter of its weight
    if (!(weight_ > 0)) return {};
    Consensus consensus;
    consensus.root = roots_ / weight_;
    consensus.broad = broad_ / weight_;
    consensus.weight = weight_;
    const float spread2 = std::max(0.0f, squares_ / weight_ - glm::dot(consensus.root, consensus.root));
    consensus.tolerance2 = tolerance * tolerance + kSpreads * kSpreads * spread2;
    return consensus;
  }

 private:
  glm::vec3 roots_{0.0f}, broad_{0.0f};
  float squares_ = 0, weight_ = 0;
};

}  // namespace lumatlas
