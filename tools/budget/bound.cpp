// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/bound.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace lumatlas {

namespace {

void check_loss(const std::string& name, double loss_db) {
  if (std::isfinite(loss_db) && loss_db >= 0) return;
  throw std::invalid_argument("bound: " + name + " is " + std::to_string(loss_db) +
                              ", must be finite and not negative");
}

}  // namespace

Bound Bound::of_array(std::uint64_t bytes) {
  Bound bound;
  bound.kind_ = Kind::array;
  bound.bytes_ = bytes;
  return bound;
}

Bound Bound::of_gpu(std::uint64_t bytes) {
  Bound bound;
  bound.kind_ = Kind::gpu;
  bound.bytes_ = bytes;
  return bound;
}

Bound Bound::of_loss(double texels_db, double faces_db) {
  Bound bound;
  bound.kind_ = Kind::loss;
  bound.texel_loss_db_ = texels_db;
  bound.face_loss_db_ = faces_db;
  return bound;
}

void check(const Bound& bound) {
  check_loss("texel_loss_db", bound.texel_loss_db());
  check_loss("face_loss_db", bound.face_loss_db());
}

}  // namespace lumatlas
